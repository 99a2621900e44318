//! Delimited text, some rows at a time: comma, semicolon, tab or blanks; `#` starts a comment line; one
//! header line.
//!
//! Memory is that of the rows handed out: a row has at most [`ROW`] bytes, and a table at most `MAX_CELLS` numbers.

use std::cell::Cell;
use std::io::{BufRead, BufReader, Cursor, Error as IoError, ErrorKind, Read};
use std::path::Path;
use std::rc::Rc;

use crate::Error;
use crate::formats::content::{Content, HEAD as MAGIC};
use crate::table::{MAX_CELLS, Table, check_header};

/// Bytes in which the header must stand.
const HEAD: u64 = 1 << 20;

/// Bytes from one row to the next; ten thousand numbers with all their digits take a quarter of it.
const ROW: usize = 1 << 20;

/// Cells that are not there, up to which a file of ragged rows is read on.
const MISSING: usize = 1 << 22;

/// Rows of a text on their way into tables.
pub struct TableReader<'a> {
    file: String,
    header: Vec<String>,
    reader: csv::Reader<Box<dyn Read + 'a>>,
    record: csv::ByteRecord,
    /// Bytes read since the last row.
    since: Rc<Cell<usize>>,
    delimiter: Option<u8>,
    /// A row already read, and its line.
    waiting: Option<(usize, csv::ByteRecord)>,
    /// Rows handed out so far.
    rows: usize,
}

impl<'a> TableReader<'a> {
    /// Opens a file, plain or gzip by its first bytes.
    ///
    /// Fails when it cannot be read, is no text, or has no header.
    pub fn open(path: &Path) -> Result<TableReader<'static>, Error> {
        let file = path.display().to_string();
        let failed = |e: IoError| Error::at(&file, 0, format!("cannot be read: {e}"));
        let mut source = std::fs::File::open(path).map_err(failed)?;
        let mut head = Vec::new();
        source.by_ref().take(MAGIC as u64).read_to_end(&mut head).map_err(failed)?;
        TableReader::of_content(&file, Content::of(&head), Cursor::new(head).chain(source))
    }

    /// Reads the header of a text, or of one in a gzip stream.
    pub fn of_content(file: &str, content: Content, source: impl Read + 'a) -> Result<TableReader<'a>, Error> {
        match content {
            Content::Gzip => TableReader::new(file, flate2::read::MultiGzDecoder::new(BufReader::new(source))),
            _ => TableReader::new(file, source),
        }
    }

    /// Reads the header of a text.
    pub fn new(file: &str, mut text: impl Read + 'a) -> Result<TableReader<'a>, Error> {
        let mut head = Vec::new();
        let failed = |e: IoError| unreadable(file, 0, &e);
        text.by_ref().take(HEAD).read_to_end(&mut head).map_err(failed)?;
        if head.starts_with("\u{feff}".as_bytes()) {
            head.drain(..3);
        }
        if head.is_empty() {
            return Err(Error::at(file, 0, "the file is empty; a header line and rows of numbers are expected"));
        }
        if head.starts_with(b"\xff\xfe") || head.starts_with(b"\xfe\xff") {
            return Err(Error::at(file, 0, "this text is in UTF-16; save it as UTF-8"));
        }
        if head.iter().take(4096).any(|&b| b == 0) {
            return Err(Error::at(file, 0, "this is a binary file; delimited text with a header line is expected"));
        }
        let is_comment = |l: &[u8]| l.trim_ascii_start().starts_with(b"#");
        let lines = || head.split(|&b| b == b'\n').enumerate().filter(|(_, l)| !l.trim_ascii().is_empty());
        let (line, first) = lines()
            .find(|(_, l)| !is_comment(l))
            .ok_or_else(|| Error::at(file, 0, "only blank lines and comments; a header line is expected"))?;
        let delimiter = delimiter(first);
        // numpy.savetxt writes the header as a comment above the numbers.
        let comment =
            lines().take_while(|(_, l)| is_comment(l)).last().map(|(_, l)| l.trim_ascii_start()[1..].to_vec());
        let text = Cursor::new(head).chain(text);
        let text: Box<dyn Read + 'a> = match delimiter {
            Some(_) => Box::new(text),
            None => Box::new(Squeezed { text: BufReader::new(text), line: Vec::new(), at: 0 }),
        };
        let since = Rc::new(Cell::new(0));
        let text: Box<dyn Read + 'a> = Box::new(Metered { text, since: Rc::clone(&since) });
        let mut reader = csv::ReaderBuilder::new()
            .delimiter(delimiter.unwrap_or(b' '))
            .comment(Some(b'#'))
            .trim(csv::Trim::All)
            .flexible(true)
            .from_reader(text);
        let mut header: Vec<String> = match reader.byte_headers() {
            Ok(h) => h.iter().map(|c| String::from_utf8_lossy(c).into_owned()).collect(),
            Err(e) => return Err(Error::at(file, line + 1, format!("the header cannot be read: {}", told(&e)))),
        };
        let mut waiting = None;
        if header.iter().all(|h| number(h, delimiter).is_some()) {
            let names = |c: Vec<u8>| split(&String::from_utf8_lossy(&c), delimiter);
            let names =
                comment.map(names).filter(|n| n.len() == header.len() && n.iter().all(|n| n.parse::<f64>().is_err()));
            if let Some(names) = names {
                waiting = Some((line + 1, csv::ByteRecord::from(std::mem::replace(&mut header, names))));
            }
        }
        check_header(file, line + 1, &header)?;
        Ok(TableReader {
            file: file.into(),
            header,
            delimiter,
            reader,
            record: csv::ByteRecord::new(),
            since,
            waiting,
            rows: 0,
        })
    }

    /// How many columns the header names.
    pub fn width(&self) -> usize {
        self.header.len()
    }

    /// The next rows, at most `most`; none at the end.
    ///
    /// Fails when a row cannot be read, when there are more numbers than [`MAX_CELLS`], or when most cells are not there.
    pub fn rows(&mut self, most: usize) -> Result<Table, Error> {
        let mut table = Table {
            file: self.file.clone(),
            columns: vec![Vec::new(); self.header.len()],
            texts: vec![None; self.header.len()],
            header: self.header.clone(),
            skipped: self.rows,
            ..Table::default()
        };
        if let Some((line, row)) = self.waiting.take() {
            push(&mut table, line, &row, self.delimiter);
        }
        while table.rows() < most {
            let line = self.reader.position().line() as usize;
            self.since.set(0);
            match self.reader.read_byte_record(&mut self.record) {
                Ok(false) => break,
                Ok(true) => {
                    let line = self.record.position().map_or(line, |p| p.line() as usize);
                    // A row of units under the header is part of it.
                    if self.rows + table.rows() == 0 && self.record.iter().all(|c| is_word(c, self.delimiter)) {
                        let units = self.record.iter().map(|c| String::from_utf8_lossy(c).into_owned());
                        for (header, unit) in self.header.iter_mut().zip(units) {
                            *header = format!("{header}_{unit}");
                        }
                        table.header.clone_from(&self.header);
                        continue;
                    }
                    push(&mut table, line, &self.record, self.delimiter);
                    self.check_size(&table, line)?;
                }
                Err(e) => match e.kind() {
                    csv::ErrorKind::Io(e) => return Err(unreadable(&self.file, line, e)),
                    _ => return Err(Error::at(&self.file, line, format!("the row cannot be read: {e}"))),
                },
            }
        }
        self.rows += table.rows();
        Ok(table)
    }

    /// Refuses a table that outgrows its bounds.
    fn check_size(&self, table: &Table, line: usize) -> Result<(), Error> {
        let (rows, width) = (table.rows(), self.header.len());
        if rows.saturating_mul(width) > MAX_CELLS {
            let message =
                format!("more than {MAX_CELLS} numbers; keep the columns of the robot, or cut the log into parts");
            return Err(Error::at(&self.file, line, message));
        }
        if table.ragged > rows / 2 && table.ragged.saturating_mul(width) > MISSING {
            let message = format!("{} of {rows} rows have more or fewer cells than the header has names", table.ragged);
            return Err(Error::at(&self.file, line, message));
        }
        Ok(())
    }
}

/// What csv says of an error, without the words around those of the system.
fn told(e: &csv::Error) -> String {
    match e.kind() {
        csv::ErrorKind::Io(e) => e.to_string(),
        _ => e.to_string(),
    }
}

fn unreadable(file: &str, line: usize, e: &IoError) -> Error {
    match e.kind() {
        // The ways in which a decoder says that its input is none.
        ErrorKind::InvalidInput | ErrorKind::InvalidData | ErrorKind::UnexpectedEof => {
            Error::at(file, line, format!("the gzip stream is damaged or cut short: {e}"))
        }
        _ => Error::at(file, line, format!("cannot be read: {e}")),
    }
}

fn push(table: &mut Table, line: usize, record: &csv::ByteRecord, delimiter: Option<u8>) {
    // A delimiter at the end of each row is a habit, not a cell.
    let more = record.iter().skip(table.header.len()).any(|cell| !cell.is_empty());
    table.ragged += usize::from(record.len() < table.header.len() || more);
    table.lines.push(line);
    for (c, column) in table.columns.iter_mut().enumerate() {
        let cell = record.get(c).unwrap_or(b"");
        let x = std::str::from_utf8(cell).ok().and_then(|cell| number(cell, delimiter));
        if x.is_none() && table.texts[c].is_none() {
            table.texts[c] = Some((line, String::from_utf8_lossy(cell).into_owned()));
        }
        column.push(x.unwrap_or(f64::NAN));
    }
}

fn too_long() -> IoError {
    let message = format!(
        "{ROW} bytes without the end of a row: a line that is too long, a quotation mark that is never closed, or no rows"
    );
    IoError::new(ErrorKind::FileTooLarge, message)
}

/// Refuses a text that goes on and on without a row.
struct Metered<R> {
    text: R,
    since: Rc<Cell<usize>>,
}

impl<R: Read> Read for Metered<R> {
    fn read(&mut self, out: &mut [u8]) -> std::io::Result<usize> {
        if self.since.get() > ROW {
            return Err(too_long());
        }
        let read = self.text.read(out)?;
        self.since.set(self.since.get() + read);
        Ok(read)
    }
}

/// Runs of blanks made one and lines trimmed, for files separated by blanks.
struct Squeezed<R> {
    text: BufReader<R>,
    line: Vec<u8>,
    at: usize,
}

impl<R: Read> Read for Squeezed<R> {
    fn read(&mut self, out: &mut [u8]) -> std::io::Result<usize> {
        if self.at == self.line.len() {
            let mut line = Vec::new();
            if self.text.by_ref().take(ROW as u64 + 1).read_until(b'\n', &mut line)? == 0 {
                return Ok(0);
            }
            if line.len() > ROW {
                return Err(too_long());
            }
            let words = line.split(u8::is_ascii_whitespace).filter(|w| !w.is_empty());
            self.line = words.collect::<Vec<_>>().join(&b' ');
            self.line.push(b'\n');
            self.at = 0;
        }
        let count = out.len().min(self.line.len() - self.at);
        out[..count].copy_from_slice(&self.line[self.at..self.at + count]);
        self.at += count;
        Ok(count)
    }
}

/// A number, or NaN for the ways in which files say that there is none; `None` for other text.
///
/// Between semicolons and tabs a comma is a decimal one. A date with its time is in s since 1970.
fn number(cell: &str, delimiter: Option<u8>) -> Option<f64> {
    if let Ok(x) = cell.parse::<f64>() {
        return Some(x);
    }
    if matches!(cell.to_ascii_lowercase().as_str(), "" | "na" | "n/a" | "null" | "none" | "-" | "?") {
        return Some(f64::NAN);
    }
    if delimiter != Some(b',') && cell.bytes().filter(|&b| b == b',').count() == 1 && !cell.contains('.') {
        return cell.replace(',', ".").parse().ok();
    }
    date(cell)
}

/// `2026-11-21 07:49:04.25`, also with a `T` between and a `Z` behind: s since 1970.
fn date(cell: &str) -> Option<f64> {
    let (day, time) = cell.trim_end_matches('Z').split_once(['T', ' '])?;
    let parts = |text: &str, separator: char| -> Option<[f64; 3]> {
        let numbers: Option<Vec<f64>> = text.split(separator).map(|n| n.parse().ok()).collect();
        numbers?.try_into().ok()
    };
    let ([year, month, day], [hours, minutes, seconds]) = (parts(day, '-')?, parts(time, ':')?);
    let inside = (1970.0..2100.0).contains(&year) && (1.0..13.0).contains(&month) && (1.0..32.0).contains(&day);
    // Days since 1970 of the civil calendar; the year begins in March.
    let (y, m) = if month > 2.0 { (year, month - 3.0) } else { (year - 1.0, month + 9.0) };
    let days = 365.0 * y + (y / 4.0).floor() - (y / 100.0).floor() + (y / 400.0).floor();
    let days = days + ((153.0 * m + 2.0) / 5.0).floor() + day - 719_469.0;
    inside.then_some(86_400.0 * days + 3600.0 * hours + 60.0 * minutes + seconds)
}

/// Whether a cell is a word: text, and no number.
fn is_word(cell: &[u8], delimiter: Option<u8>) -> bool {
    std::str::from_utf8(cell).is_ok_and(|cell| number(cell, delimiter).is_none())
}

/// The words of a line.
fn split(line: &str, delimiter: Option<u8>) -> Vec<String> {
    let words: Vec<&str> = match delimiter {
        Some(d) => line.split(char::from(d)).collect(),
        None => line.split_whitespace().collect(),
    };
    words.into_iter().map(|w| w.trim().to_string()).collect()
}

fn delimiter(line: &[u8]) -> Option<u8> {
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
        assert_eq!(
            (savetxt.header.clone(), savetxt.columns[1].clone()),
            (vec!["t".into(), "q1".into()], vec![1.0, 2.0])
        );
        assert_eq!(savetxt.line(0), 3);
        let units = table("t,q1\ns,deg\n0,1\n");
        assert_eq!((units.header.clone(), units.columns[1].clone()), (vec!["t_s".into(), "q1_deg".into()], vec![1.0]));
    }

    #[test]
    fn decimal_commas_and_dates() {
        let euro = table("t;q1\n0,5;1,25\n1;1.5\n");
        assert_eq!(euro.columns, [[0.5, 1.0], [1.25, 1.5]]);
        // Seconds of `date -u -d .. +%s`.
        for (text, seconds) in [
            ("1970-01-01 00:00:00", 0.0),
            ("2000-02-29T12:00:00Z", 951_825_600.0),
            ("2026-11-21 07:49:04.25", 1_795_247_344.25),
        ] {
            assert_eq!(date(text), Some(seconds), "{text}");
        }
        assert_eq!(date("2026-13-01 00:00:00"), None);
        assert_eq!(date("elbow up"), None);
    }
}
