//! Reads delimited text, some rows at a time. The delimiter is a comma, a semicolon, a tab or blanks; `#` starts a comment line;
//! there is one header line.
//!
//! The text is read in windows, and each window is divided into blocks of whole rows. Several threads read the blocks. The
//! results are joined in order, so they do not depend on the number of threads. The memory is bounded by a window and the
//! returned rows: a row has at most [`MAX_ROW_BYTES`] bytes, a table at most `MAX_CELLS` numbers. `rows` defines what a row is.

use std::io::{Error as IoError, ErrorKind, Read};

use gate::shown;
use gate::unfolding::{PackedBytes, Unfolding};
use memchr::memchr_iter;
use processor::{in_parallel, threads};

use crate::Error;
use crate::formats::number::{is_word, number};
use crate::formats::rows::{Block, Dialect, WholeRows};
use crate::table::{MAX_CELLS, RowReader, Table, check_header};

/// The header must end within this number of bytes.
const MAX_HEADER_BYTES: u64 = 1 << 20;

/// Largest number of bytes of a block, and of a row including the comment and empty lines before it. Ten thousand numbers of
/// full length need only a quarter of this size.
const MAX_ROW_BYTES: usize = 1 << 20;

/// Largest number of blocks in a window.
const BLOCKS_PER_WINDOW: usize = 8;

/// Largest number of values in a block. It limits blocks with short rows.
const MAX_CELLS_PER_TEXT_BLOCK: usize = 1 << 18;

/// A smaller number of bytes is read by one thread, because starting a second thread would take as long.
const MIN_BYTES_FOR_THREADS: usize = 1 << 18;
/// If one of this number of first bytes is zero, the file is binary.
const BINARY_CHECK_BYTES: usize = 4096;

/// If most rows are ragged (have more or fewer cells than the header), the file is refused as soon as these rows have more than
/// this number of cells.
const MAX_RAGGED_CELLS: usize = 1 << 21;

/// Memory for one number in a table, bytes. A column grows by doubling, so the old and the new memory are in use together.
const MEMORY_PER_NUMBER_BYTES: usize = 3 * size_of::<f64>();

/// Reads a text in rows.
pub(crate) struct TableReader<'a> {
    file: String,
    header: Vec<String>,
    dialect: Dialect,
    text: Box<dyn Read + Send + 'a>,
    /// Counts the bytes of a compressed text; `None` if the text is not compressed.
    packed: Option<PackedBytes>,
    /// The window. The bytes from `at` on are not read yet.
    window: Vec<u8>,
    at: usize,
    /// Whether the window contains the end of the text.
    is_last: bool,
    /// Number of line ends before the window position `at`.
    ends: usize,
    /// Number of bytes that were read since the last row (comments and empty lines).
    idle: usize,
    /// A row that was read together with the header, and its line.
    waiting: Option<(usize, Vec<Vec<u8>>)>,
    /// Notes on unusual properties of the text.
    notes: Vec<String>,
    /// Number of rows that were returned so far.
    rows: usize,
    threads: usize,
}

/// The note on a text that begins with numbers.
pub(crate) const NO_HEADER: &str = "the file has no header: its columns are c1, c2, .., for [options.columns] to name";

impl<'a> TableReader<'a> {
    /// Reads the header of a compressed text.
    pub(crate) fn unfolding(file: &str, text: Unfolding<impl Read + Send + 'a>) -> Result<TableReader<'a>, Error> {
        let packed = Some(text.packed());
        Ok(TableReader { packed, ..TableReader::new(file, text)? })
    }

    /// Starts to read a text with its header.
    pub(crate) fn new(file: &str, mut text: impl Read + Send + 'a) -> Result<TableReader<'a>, Error> {
        let mut head = Vec::new();
        let failed = |e: IoError| unreadable(file, 0, &e);
        text.by_ref().take(MAX_HEADER_BYTES).read_to_end(&mut head).map_err(failed)?;
        if head.starts_with("\u{feff}".as_bytes()) {
            head.drain(..3);
        }
        if head.is_empty() {
            return Err(Error::at(file, 0, "the file is empty; a header line and rows of numbers are expected"));
        }
        if head.iter().take(BINARY_CHECK_BYTES).any(|&b| b == 0) {
            return Err(Error::at(file, 0, "this is a binary file; delimited text with a header line is expected"));
        }
        let is_comment = |l: &[u8]| l.trim_ascii_start().starts_with(b"#");
        let lines = || head.split(|&b| b == b'\n').enumerate().filter(|(_, l)| !l.trim_ascii().is_empty());
        let (line, first) = lines()
            .find(|(_, l)| !is_comment(l))
            .ok_or_else(|| Error::at(file, 0, "only blank lines and comments; a header line is expected"))?;
        let delimiter = delimiter(first);
        // numpy.savetxt writes the header as a comment before the numbers.
        let comment =
            lines().take_while(|(_, l)| is_comment(l)).last().map(|(_, l)| l.trim_ascii_start()[1..].to_vec());
        let start = head.split_inclusive(|&b| b == b'\n').take(line).map(<[u8]>::len).sum::<usize>();
        let dialect = Dialect { delimiter, wanted: Vec::new() };
        let Some(row) = dialect.first_row(&head[start..]).filter(|row| start + row.bytes < MAX_HEADER_BYTES as usize)
        else {
            return Err(Error::at(file, line + 1, format!("the header cannot be read: {}", too_long())));
        };
        let mut header: Vec<String> = row.cells.iter().map(|c| String::from_utf8_lossy(c).into_owned()).collect();
        let (mut waiting, mut notes) = (None, Vec::new());
        if row.cells.iter().all(|h| number(h, delimiter).is_some()) {
            let names = |c: Vec<u8>| split(&String::from_utf8_lossy(&c), delimiter);
            let names =
                comment.map(names).filter(|n| n.len() == header.len() && n.iter().all(|n| n.parse::<f64>().is_err()));
            // Without a header a column is named by its position.
            notes.extend(names.is_none().then(|| NO_HEADER.to_string()));
            let names = names.unwrap_or_else(|| (1..=header.len()).map(|k| format!("c{k}")).collect());
            (header, waiting) = (names, Some((line + 1, row.cells)));
        }
        check_header(file, line + 1, &mut header)?;
        Ok(TableReader {
            file: file.into(),
            dialect: Dialect { wanted: vec![true; header.len()], ..dialect },
            header,
            text: Box::new(text),
            packed: None,
            at: start + row.bytes,
            is_last: head.len() < MAX_HEADER_BYTES as usize,
            window: head,
            ends: line + row.ends,
            idle: 0,
            waiting,
            notes,
            rows: 0,
            threads: threads(),
        })
    }

    /// The next rows, at most `most`. An empty table means the end of the text.
    ///
    /// Fails if a row cannot be read, if there are more than [`MAX_CELLS`] numbers, or if most cells are missing.
    fn next_rows(&mut self, most: usize) -> Result<Table, Error> {
        self.units()?;
        let mut table = Table {
            file: self.file.clone(),
            columns: vec![Vec::new(); self.header.len()],
            texts: vec![None; self.header.len()],
            header: self.header.clone(),
            skipped: self.rows,
            notes: self.notes.clone(),
            ..Table::default()
        };
        // The row that was read together with the header is the first row.
        if most > 0
            && let Some((line, cells)) = self.waiting.take()
        {
            let delimiter = self.dialect.delimiter.unwrap_or(b' ');
            let row = quoted(&cells, delimiter);
            let block = self.dialect.read(&row, WholeRows { bytes: row.len(), most: 1, are_plain: false });
            self.append(&mut table, &block, line)?;
        }
        // Several threads read blocks of whole rows. The blocks are appended in the order of the file.
        while table.rows() < most {
            let cuts = self.cuts(most - table.rows())?;
            if cuts.is_empty() {
                break;
            }
            let blocks = self.read(&cuts);
            let more = blocks.iter().map(|block| block.rows).sum();
            let wanted = table.columns.iter_mut().zip(&self.dialect.wanted).filter(|(_, wanted)| **wanted);
            wanted.for_each(|(column, _)| column.reserve(more));
            for (block, bytes) in blocks.into_iter().zip(cuts.iter().map(|cut| cut.bytes)) {
                self.at += bytes;
                // Bytes without rows also need memory, so their number is bounded.
                self.idle = if block.rows == 0 { self.idle + bytes } else { 0 };
                if self.idle > MAX_ROW_BYTES {
                    return Err(unreadable(&self.file, self.ends + 1, &too_long()));
                }
                self.append(&mut table, &block, self.ends + 1)?;
                self.ends += block.ends;
            }
        }
        self.rows += table.rows();
        Ok(table)
    }

    /// If rows with units follow the header, appends the units to the header names.
    fn units(&mut self) -> Result<(), Error> {
        while self.rows == 0 && self.waiting.is_none() {
            self.fill(MAX_ROW_BYTES)?;
            let Some(row) = self.dialect.first_row(&self.window[self.at..]) else { break };
            let is_whole = self.is_last || self.at + row.bytes < self.window.len();
            if !is_whole || !row.cells.iter().all(|c| is_word(c, self.dialect.delimiter)) {
                break;
            }
            for (header, unit) in self.header.iter_mut().zip(&row.cells) {
                *header = format!("{header}_{}", shown::line(&String::from_utf8_lossy(unit)));
            }
            (self.at, self.ends) = (self.at + row.bytes, self.ends + row.ends);
        }
        Ok(())
    }

    /// Fills the window until it has this number of unread bytes, or until the text ends.
    fn fill(&mut self, bytes: usize) -> Result<(), Error> {
        let unread = self.window.len() - self.at;
        if self.is_last || unread >= bytes {
            return Ok(());
        }
        self.window.drain(..self.at);
        self.at = 0;
        let missing = (BLOCKS_PER_WINDOW * MAX_ROW_BYTES - unread) as u64;
        // Reserves exactly the needed memory, because growth by doubling would take up to twice a window.
        self.window.reserve_exact(missing as usize);
        let read = self.text.by_ref().take(missing).read_to_end(&mut self.window).map_err(|e| {
            let line = self.ends + 1 + memchr_iter(b'\n', &self.window).count();
            unreadable(&self.file, line, &e)
        })?;
        self.is_last = (read as u64) < missing;
        Ok(())
    }

    /// Divides the window into blocks of whole rows, with at most `most` rows together.
    fn cuts(&mut self, most: usize) -> Result<Vec<WholeRows>, Error> {
        self.fill(MAX_ROW_BYTES + 1)?;
        let (mut at, mut left, mut cuts) = (self.at, most, Vec::new());
        let room = (MAX_CELLS_PER_TEXT_BLOCK / self.header.len()).max(1);
        while left > 0 && at < self.window.len() && cuts.len() < BLOCKS_PER_WINDOW {
            let end = self.window.len().min(at + MAX_ROW_BYTES);
            let is_last = self.is_last && end == self.window.len();
            let rows = self.dialect.whole_rows(&self.window[at..end], left.min(room), is_last);
            if rows.bytes == 0 {
                if cuts.is_empty() && end - at == MAX_ROW_BYTES {
                    return Err(unreadable(&self.file, self.ends + 1, &too_long()));
                }
                break;
            }
            cuts.push(rows);
            (at, left) = (at + rows.bytes, left - rows.most);
        }
        Ok(cuts)
    }

    /// Reads blocks on several threads; the results have the order of the blocks.
    fn read(&self, cuts: &[WholeRows]) -> Vec<Block> {
        let mut at = self.at;
        let texts: Vec<(&[u8], WholeRows)> = cuts
            .iter()
            .map(|&rows| {
                at += rows.bytes;
                (&self.window[at - rows.bytes..at], rows)
            })
            .collect();
        let dialect = &self.dialect;
        let threads = if at - self.at < MIN_BYTES_FOR_THREADS { 1 } else { self.threads };
        in_parallel(texts, threads, |(text, rows)| dialect.read(text, rows))
    }

    /// Appends a block to the table. `line`: number of the first line of the block.
    ///
    /// Fails if the table becomes too large, or if most rows are ragged.
    fn append(&self, table: &mut Table, block: &Block, line: usize) -> Result<(), Error> {
        let (rows, width) = (table.lines.len(), self.header.len());
        let wanted = self.dialect.wanted.iter().zip(&mut table.columns).filter(|(wanted, _)| **wanted);
        for (k, (_, column)) in wanted.enumerate() {
            column.extend_from_slice(block.column(k));
        }
        table.lines.append(&block.lines, line);
        for (text, found) in table.texts.iter_mut().zip(&block.texts) {
            if let (None, Some((above, found))) = (&text, found) {
                *text = Some((line + above, found.clone()));
            }
        }
        // If most rows are ragged, the file is refused before it fills the memory.
        for row in block.ragged.iter().map(|row| rows + row) {
            table.ragged += 1;
            if table.ragged > row.div_ceil(2) && table.ragged.saturating_mul(width) > MAX_RAGGED_CELLS {
                let message =
                    format!("{} of {} rows have more or fewer cells than the header has names", table.ragged, row + 1);
                return Err(Error::at(&self.file, table.line(row), message));
            }
        }
        // For a compressed file, the memory of the numbers is also taken from the memory budget of the file.
        if let Some(packed) = &self.packed {
            let numbers = self.dialect.wanted.iter().filter(|wanted| **wanted).count().saturating_mul(table.rows());
            let drawn = packed.budget().draw(numbers.saturating_mul(MEMORY_PER_NUMBER_BYTES));
            drawn.map_err(|e| Error::at(&self.file, 0, e))?;
        }
        if table.rows().saturating_mul(width) > MAX_CELLS {
            let message =
                format!("more than {MAX_CELLS} numbers; keep the columns of the robot, or cut the log into parts");
            return Err(Error::at(&self.file, table.line(MAX_CELLS / width), message));
        }
        Ok(())
    }
}

impl RowReader for TableReader<'_> {
    fn width(&self) -> usize {
        self.header.len()
    }

    fn keep(&mut self, columns: &[usize]) {
        self.dialect.wanted.fill(false);
        for column in columns {
            self.dialect.wanted[*column] = true;
        }
    }

    fn rows(&mut self, most: usize) -> Result<Table, Error> {
        self.next_rows(most)
    }
}

/// Writes cells as a row of text. Reading this row gives the same cells.
fn quoted(cells: &[Vec<u8>], delimiter: u8) -> Vec<u8> {
    let quoted = |cell: &Vec<u8>| {
        let doubled = cell.iter().flat_map(|&b| if b == b'"' { vec![b, b] } else { vec![b] });
        std::iter::once(b'"').chain(doubled).chain([b'"']).collect::<Vec<u8>>()
    };
    cells.iter().map(quoted).collect::<Vec<_>>().join(&delimiter)
}

/// The error of a stream, by its kind.
pub(crate) fn unreadable(file: &str, line: usize, e: &IoError) -> Error {
    match e.kind() {
        // A decoder reports these kinds of error for damaged input.
        ErrorKind::InvalidInput | ErrorKind::InvalidData | ErrorKind::UnexpectedEof => {
            Error::at(file, line, format!("the compressed stream is damaged or cut short: {e}"))
        }
        _ => Error::at(file, line, format!("cannot be read: {e}")),
    }
}

fn too_long() -> IoError {
    let message = format!(
        "{MAX_ROW_BYTES} bytes without the end of a row: a line that is too long, a quotation mark that is never closed, or no rows"
    );
    IoError::new(ErrorKind::FileTooLarge, message)
}

/// The words of a line, without blanks at their ends.
fn split(line: &str, delimiter: Option<u8>) -> Vec<String> {
    let words: Vec<&str> = match delimiter {
        Some(d) => line.split(char::from(d)).collect(),
        None => line.split_whitespace().collect(),
    };
    words.into_iter().map(|w| w.trim().to_string()).collect()
}

/// The delimiter of a header.
pub(super) fn delimiter(line: &[u8]) -> Option<u8> {
    [b',', b';', b'\t'].into_iter().find(|d| line.contains(d))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(text: &str) -> Table {
        TableReader::new("log.csv", text.as_bytes()).unwrap().rows(usize::MAX).unwrap()
    }

    #[test]
    fn some_rows_at_a_time() {
        let mut reader = TableReader::new("log.csv", "t,q\n0,1\n1,2\n2,3\n".as_bytes()).unwrap();
        let first = reader.rows(2).unwrap();
        let second = reader.rows(2).unwrap();
        assert_eq!((first.columns[1].clone(), first.skipped), (vec![1.0, 2.0], 0));
        assert_eq!((second.columns[1].clone(), second.skipped, second.line(0)), (vec![3.0], 2, 4));
        assert_eq!(reader.rows(2).unwrap().rows(), 0);
    }

    #[test]
    fn headers_in_comments_and_rows_of_units() {
        let savetxt = table("# written by hand\n# t q1\n0.0 1.0\n0.1 2.0\n");
        assert_eq!((savetxt.header.join(" "), &savetxt.columns[1]), ("t q1".into(), &vec![1.0, 2.0]));
        assert_eq!((savetxt.line(0), savetxt.line(1)), (3, 4));
        let units = table("t,q1\ns,deg\n0,1\n");
        assert_eq!((units.header.join(" "), units.columns[1][0], units.line(0)), ("t_s q1_deg".into(), 1.0, 3));
    }

    #[test]
    fn decimal_commas() {
        let euro = table("t;q1\n0,5;1,25\n1;1.5\n");
        assert_eq!(euro.columns, [[0.5, 1.0], [1.25, 1.5]]);
    }

    /// A pseudo-random number from a linear congruential generator. The lowest 20 bits of the state are not used.
    fn random(state: &mut u64) -> u64 {
        *state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        *state >> 20
    }

    #[test]
    fn numbers_are_those_of_the_standard_library() {
        let mut state = 7;
        let mut written = Vec::new();
        for i in 0..60_000 {
            let (a, b, c) = (random(&mut state), random(&mut state), random(&mut state));
            let sign = ["", "-", "+"][i % 3];
            written.push(match i % 6 {
                0 => format!("{sign}{}.{:06}", a % 100, b % 1_000_000),
                1 => format!("{sign}{a}{b}.{c}{a}"),
                2 => format!("{sign}{}.{a}e{}", b % 10, c % 700).replace("e", if c % 2 == 0 { "e-" } else { "E" }),
                3 => format!("{sign}{}", f64::from_bits(a << 20 ^ b)),
                4 => format!("{sign}{:e}", f64::from_bits((a << 20 ^ b) >> (12 + c % 40))),
                _ => format!("{sign}.{:019}e{}", a, c % 30),
            });
        }
        let text = written.chunks(3).fold("t,a,b\n".to_string(), |text, row| text + &row.join(",") + "\n");
        let table = table(&text);
        assert_eq!((table.rows(), table.ragged), (20_000, 0));
        for (i, written) in written.iter().enumerate() {
            let (found, expected) = (table.columns[i % 3][i / 3], written.parse::<f64>().unwrap());
            let are_none = found.is_nan() && expected.is_nan();
            assert!(found.to_bits() == expected.to_bits() || are_none, "{written}: {found}");
        }
    }

    #[test]
    fn blocks_and_threads_change_nothing() {
        let mut state = 3;
        let mut text = String::from("t;q1;mode;tau1\r\n");
        let mut lines = Vec::new();
        let mut line = 2;
        while text.len() < 20 << 20 {
            let i = random(&mut state);
            let row = match i % 50 {
                0 => "# a comment with a \" mark\n".to_string(),
                1 => "\r\n".to_string(),
                2 => format!("{i};\"1;5\nand \"\"more\"\"\";auto;1\n"),
                3 => format!("{i};0,25;\"manual\";2;\n"),
                4 => format!("{i};1e-3\n"),
                5 => format!(" {i} ; 3 ; auto ; - \n"),
                _ => format!("{i};{}.{:04};auto;{}\n", i % 7, i % 9973, i % 1009),
            };
            if i % 50 > 1 {
                lines.push(line);
            }
            line += row.matches('\n').count();
            text += &row;
        }
        let read = |threads: usize, most: usize| {
            let mut reader = TableReader::new("log.csv", text.as_bytes()).unwrap();
            reader.threads = threads;
            let mut whole = reader.rows(most).unwrap();
            loop {
                let part = reader.rows(most).unwrap();
                if part.rows() == 0 {
                    break whole;
                }
                assert!(part.rows() == most || part.rows() + part.skipped == lines.len());
                whole.lines.append(&part.lines, 0);
                whole.ragged += part.ragged;
                whole.columns.iter_mut().zip(&part.columns).for_each(|(a, b)| a.extend_from_slice(b));
            }
        };
        let bits = |table: &Table| -> Vec<u64> { table.columns.iter().flatten().map(|x| x.to_bits()).collect() };
        let (expected, first) = (read(1, usize::MAX), lines.len());
        assert_eq!(expected.rows(), first);
        assert!((0..first).all(|r| expected.line(r) == lines[r]));
        assert_eq!(expected.texts[2], Some((lines[0], "auto".into())));
        assert!(expected.texts[1].as_ref().is_some_and(|(_, text)| text == "1;5\nand \"more\""));
        for (threads, most) in [(2, usize::MAX), (5, usize::MAX), (2, 65_536), (1, 1013)] {
            let found = read(threads, most);
            assert_eq!(bits(&found), bits(&expected), "{threads} {most}");
            assert_eq!((found.lines.clone(), found.ragged), (expected.lines.clone(), expected.ragged));
        }
    }

    #[test]
    fn columns_nobody_wants_are_left_out() {
        let mut reader = TableReader::new("log.csv", "t,a,q\n0,\"x\n\",1\n1,2,3\n".as_bytes()).unwrap();
        reader.keep(&[0, 2]);
        let table = reader.rows(9).unwrap();
        assert_eq!(table.columns, [vec![0.0, 1.0], vec![], vec![1.0, 3.0]]);
        assert_eq!((table.line(1), &table.texts), (4, &vec![None; 3]));
    }
}
