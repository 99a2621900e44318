//! Divides delimited text into blocks of rows, and reads the rows into columns.
//!
//! Blocks of whole rows are independent, so several blocks are read in parallel. A plain number is parsed without copying its
//! cell. A quotation mark at the start of a cell encloses delimiters and line ends; inside it, two marks mean one mark. `#` at
//! the start of a line marks a comment. Blank lines are no rows.

use std::borrow::Cow;

use memchr::{memchr, memchr_iter, memchr2, memchr3, memrchr};

use processor::{Work, widely};

use crate::formats::cell_ends::CellEnds;
use crate::formats::number::{leading, number};
use crate::table::Lines;

/// The delimiter of the cells, and the columns that are read.
#[derive(Clone, Debug)]
pub(super) struct Dialect {
    /// The delimiter; `None`: one or more blanks.
    pub delimiter: Option<u8>,
    /// For each column of the header, whether it is read.
    pub wanted: Vec<bool>,
}

/// The rows of a block that were read.
#[derive(Debug)]
pub(super) struct Block {
    /// The numbers, column after column, with space for `room` numbers per column. Columns that are not read have no space.
    pub data: Vec<f64>,
    room: usize,
    /// Number of rows.
    pub rows: usize,
    /// Line numbers of the rows in the file.
    pub lines: Lines,
    /// For each column, the first cell with text: its line and the text. `None` if it has no text.
    pub texts: Vec<Option<(usize, String)>>,
    /// Indices of the rows with too few or too many cells.
    pub ragged: Vec<usize>,
    /// Number of line ends.
    pub ends: usize,
}

impl Block {
    /// The numbers of column k; only the columns that are read are counted.
    pub(super) fn column(&self, k: usize) -> &[f64] {
        &self.data[k * self.room..][..self.rows]
    }
}

impl Dialect {
    fn is_blank(&self, byte: u8) -> bool {
        self.delimiter.is_none() && byte != b'\n' && byte != b'\r' && byte.is_ascii_whitespace()
    }

    fn ends_cell(&self, byte: u8) -> bool {
        byte == b'\n' || byte == b'\r' || self.delimiter.map_or_else(|| byte.is_ascii_whitespace(), |d| byte == d)
    }

    /// The position after the blanks at `at` if blanks are the delimiter; otherwise `at`.
    fn behind_blanks(&self, bytes: &[u8], at: usize) -> usize {
        if self.delimiter.is_some() {
            return at;
        }
        at + bytes[at..].iter().take_while(|b| self.is_blank(**b)).count()
    }

    /// If the line at `at` contains no row (blank or comment): the position after this line. Otherwise `None`.
    fn behind_no_row(&self, bytes: &[u8], at: usize) -> Option<usize> {
        let first = self.behind_blanks(bytes, at);
        match bytes.get(first) {
            Some(b'\n' | b'\r') => Some(behind_end(bytes, first)),
            Some(b'#') => {
                let length = memchr2(b'\n', b'\r', &bytes[first..]).unwrap_or(bytes.len() - first);
                Some(behind_end(bytes, first + length))
            }
            Some(_) => None,
            None => Some(first),
        }
    }

    /// The cell that begins at `at`, without blanks at its ends, and the position of its end.
    fn cell<'a>(&self, bytes: &'a [u8], at: usize) -> (Cow<'a, [u8]>, usize) {
        let end = |from: usize| {
            let length = match self.delimiter {
                Some(d) => memchr3(d, b'\n', b'\r', &bytes[from..]),
                None => bytes[from..].iter().position(|b| self.ends_cell(*b)),
            };
            length.map_or(bytes.len(), |length| from + length)
        };
        if bytes.get(at) != Some(&b'"') {
            let end = end(at);
            return (Cow::Borrowed(bytes[at..end].trim_ascii()), end);
        }
        let (mut text, mut from) = (Vec::new(), at + 1);
        loop {
            let Some(length) = memchr(b'"', &bytes[from..]) else {
                text.extend_from_slice(&bytes[from..]);
                return (Cow::Owned(text.trim_ascii().to_vec()), bytes.len());
            };
            text.extend_from_slice(&bytes[from..from + length]);
            from += length + 1;
            if bytes.get(from) != Some(&b'"') {
                break;
            }
            text.push(b'"');
            from += 1;
        }
        // Text after the closing quotation mark also belongs to the cell.
        let end = end(from);
        text.extend_from_slice(&bytes[from..end]);
        (Cow::Owned(text.trim_ascii().to_vec()), end)
    }

    /// The first row, with the numbers of bytes and line ends up to its end; `None` if there is no row.
    pub(super) fn first_row(&self, bytes: &[u8]) -> Option<FirstRow> {
        let (mut at, mut above) = (0, 0);
        while let Some(next) = self.behind_no_row(bytes, at) {
            if next >= bytes.len() {
                return None;
            }
            (at, above) = (next, above + 1);
        }
        let (start, mut cells) = (at, Vec::new());
        loop {
            let (cell, end) = self.cell(bytes, at);
            cells.push(cell.into_owned());
            at = end;
            match self.behind_cell(bytes, at) {
                Some(next) => at = next,
                None => break,
            }
        }
        let inside = memchr_iter(b'\n', &bytes[start..at]).count();
        let end = behind_end(bytes, self.behind_blanks(bytes, at));
        Some(FirstRow { cells, bytes: end, ends: above + inside + usize::from(end > at) })
    }

    /// The start of the next cell of the row; `None` if the row ends at `at`.
    fn behind_cell(&self, bytes: &[u8], at: usize) -> Option<usize> {
        match self.delimiter {
            Some(d) => (bytes.get(at) == Some(&d)).then_some(at + 1),
            None => {
                let next = self.behind_blanks(bytes, at);
                (next > at && bytes.get(next).is_some_and(|b| !matches!(b, b'\n' | b'\r'))).then_some(next)
            }
        }
    }

    /// The whole rows at the start of the bytes, at most `most`. `last`: whether the text ends with these bytes.
    pub(super) fn whole_rows(&self, bytes: &[u8], most: usize, last: bool) -> WholeRows {
        let is_lone = |at: usize| bytes.get(at + 1).is_some_and(|next| *next != b'\n');
        if memchr(b'"', bytes).is_some() || memchr_iter(b'\r', bytes).any(is_lone) {
            let (bytes, most) = self.whole_rows_by_cell(bytes, most, last);
            return WholeRows { bytes, most, are_plain: false };
        }
        // Counting all line ends is faster than finding every single line end, because rows are short.
        let mut count = memchr_iter(b'\n', bytes).count();
        let mut end = memrchr(b'\n', bytes).map_or(0, |at| at + 1);
        if count > most {
            count = most;
            end = memchr_iter(b'\n', bytes).take(most).last().map_or(0, |at| at + 1);
        }
        if last && count < most && end < bytes.len() {
            (end, count) = (bytes.len(), count + 1);
        }
        WholeRows { bytes: end, most: count, are_plain: true }
    }

    fn whole_rows_by_cell(&self, bytes: &[u8], most: usize, last: bool) -> (usize, usize) {
        let (mut end, mut count) = (0, 0);
        while count < most && end < bytes.len() {
            let (text, next) = match self.behind_no_row(bytes, end) {
                Some(next) => (end, next),
                None => {
                    let mut at = end;
                    loop {
                        at = self.cell(bytes, at).1;
                        match self.behind_cell(bytes, at) {
                            Some(next) => at = next,
                            None => break,
                        }
                    }
                    count += 1;
                    (at, behind_end(bytes, self.behind_blanks(bytes, at)))
                }
            };
            // If the text continues, a cell or a line end of two bytes may continue after the last byte, so the row may be
            // incomplete.
            let is_whole = next < bytes.len() || last || (next > text && bytes[next - 1] == b'\n');
            if !is_whole {
                break;
            }
            end = next;
        }
        (end, count)
    }

    /// Reads whole rows. Line numbers are counted from 0 within the block.
    pub(super) fn read(&self, bytes: &[u8], rows: WholeRows) -> Block {
        widely(Reading { dialect: self, bytes: &bytes[..rows.bytes], rows })
    }

    /// Reads the row that begins at `at`, and returns the start of the next line.
    #[inline]
    fn read_row(&self, bytes: &[u8], at: usize, places: &[Option<usize>], block: &mut Block) -> usize {
        let (row, line, width) = (block.rows, block.ends, places.len());
        block.lines.push(line);
        let mut at = self.behind_blanks(bytes, at);
        let (mut column, mut more) = (0, false);
        loop {
            let is_quoted = bytes.get(at) == Some(&b'"');
            let place = places.get(column).copied().flatten();
            let start = at + usize::from(bytes.get(at) == Some(&b' '));
            let plain = || {
                let (x, length) = leading(&bytes[start..])?;
                let is_whole = bytes.get(start + length).is_none_or(|b| self.ends_cell(*b));
                is_whole.then_some((x, start + length))
            };
            at = match place.filter(|_| !is_quoted).and_then(|_| plain()) {
                Some((x, end)) => {
                    block.data[place.unwrap_or_default() + row] = x;
                    end
                }
                None => {
                    let (cell, end) = self.cell(bytes, at);
                    more |= column >= width && !cell.is_empty();
                    if is_quoted {
                        block.ends += memchr_iter(b'\n', &bytes[at..end]).count();
                    }
                    if let Some(place) = place {
                        block.data[place + row] = self.number(&cell, line, &mut block.texts[column]);
                    }
                    end
                }
            };
            column += 1;
            match self.behind_cell(bytes, at) {
                Some(next) => at = next,
                None => break,
            }
        }
        // An empty cell after the last delimiter of a row is not counted.
        if column < width || more {
            block.ragged.push(row);
        }
        let end = behind_end(bytes, self.behind_blanks(bytes, at));
        block.ends += usize::from(end > at);
        block.rows += 1;
        end
    }

    /// The number in a cell. If the cell contains text, the result is NaN, and the first text of the column is stored.
    pub(super) fn number(&self, cell: &[u8], line: usize, text: &mut Option<(usize, String)>) -> f64 {
        number(cell, self.delimiter).unwrap_or_else(|| {
            text.get_or_insert_with(|| (line, String::from_utf8_lossy(cell).into_owned()));
            f64::NAN
        })
    }
}

/// A block of whole rows.
#[derive(Clone, Copy)]
pub(super) struct WholeRows {
    /// Number of bytes of the rows.
    pub bytes: usize,
    /// Largest number of rows.
    pub most: usize,
    /// Whether each row ends with a line feed, and there are no quotation marks.
    pub are_plain: bool,
}

/// The task of reading rows.
struct Reading<'a> {
    dialect: &'a Dialect,
    bytes: &'a [u8],
    rows: WholeRows,
}

impl Work for Reading<'_> {
    type Output = Block;

    #[inline(always)]
    fn run(self) -> Block {
        let Reading { dialect, bytes, rows } = self;
        let room = rows.most;
        // For each column that is read, the position of its first number in the block.
        let mut wanted = 0;
        let places: Vec<Option<usize>> = dialect
            .wanted
            .iter()
            .map(|is_wanted| {
                wanted += usize::from(*is_wanted);
                is_wanted.then(|| (wanted - 1) * room)
            })
            .collect();
        let mut block = Block {
            data: vec![f64::NAN; wanted * room],
            room,
            rows: 0,
            lines: Lines::default(),
            texts: vec![None; dialect.wanted.len()],
            ragged: Vec::new(),
            ends: 0,
        };
        let mut ends = dialect.delimiter.filter(|_| rows.are_plain).map(|d| CellEnds::new(bytes, d));
        let mut at = 0;
        while at < bytes.len() {
            at = match dialect.behind_no_row(bytes, at) {
                Some(next) => {
                    block.ends += usize::from(next > at && matches!(bytes[next - 1], b'\n' | b'\r'));
                    next
                }
                None => match ends.as_mut().and_then(|ends| ends.of_row(at, places.len())) {
                    Some(ends) => dialect.read_plain_row(bytes, at, ends, &places, &mut block),
                    None => dialect.read_row(bytes, at, &places, &mut block),
                },
            };
        }
        block
    }
}

/// A row as texts, with its length.
pub(super) struct FirstRow {
    /// The cells, without blanks at their ends.
    pub cells: Vec<Vec<u8>>,
    /// Number of bytes up to the end of the row.
    pub bytes: usize,
    /// Number of line ends up to the end of the row.
    pub ends: usize,
}

/// The first byte after the line end at `at`.
fn behind_end(bytes: &[u8], at: usize) -> usize {
    match (bytes.get(at), bytes.get(at + 1)) {
        (Some(b'\r'), Some(b'\n')) => at + 2,
        (Some(b'\r' | b'\n'), _) => at + 1,
        _ => at,
    }
}
