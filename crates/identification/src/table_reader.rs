//! Delimited text, some rows at a time: comma, semicolon, tab or blanks; `#` starts a comment line; one
//! header line.

use std::io::{BufRead, BufReader, Cursor, Read};
use std::path::Path;

use crate::Error;
use crate::table::Table;

/// More columns than this is not a log of a robot.
pub const MAX_COLUMNS: usize = 10_000;

/// Bytes in which the header must stand.
const HEAD: u64 = 1 << 20;

/// The first two bytes of a gzip stream.
pub const GZIP: [u8; 2] = [0x1f, 0x8b];

/// Rows of a text on their way into tables.
pub struct TableReader<'a> {
    file: String,
    header: Vec<String>,
    reader: csv::Reader<Box<dyn Read + 'a>>,
    record: csv::ByteRecord,
    /// Rows handed out so far.
    rows: usize,
}

impl<'a> TableReader<'a> {
    /// Opens a file, plain or gzip by its first bytes.
    ///
    /// Fails when it cannot be read, is no text, or has no header.
    pub fn open(path: &Path) -> Result<TableReader<'static>, Error> {
        let file = path.display().to_string();
        let failed = |e: std::io::Error| Error::at(&file, 0, format!("cannot be read: {e}"));
        let mut reader = BufReader::new(std::fs::File::open(path).map_err(failed)?);
        if reader.fill_buf().map_err(failed)?.starts_with(&GZIP) {
            TableReader::new(&file, flate2::read::MultiGzDecoder::new(reader))
        } else {
            TableReader::new(&file, reader)
        }
    }

    /// Reads the header of a text.
    pub fn new(file: &str, mut text: impl Read + 'a) -> Result<TableReader<'a>, Error> {
        let mut head = Vec::new();
        let failed = |e: std::io::Error| unreadable(file, 0, &e);
        text.by_ref().take(HEAD).read_to_end(&mut head).map_err(failed)?;
        if head.starts_with("\u{feff}".as_bytes()) {
            head.drain(..3);
        }
        if head.is_empty() {
            return Err(Error::at(file, 0, "the file is empty; a header line and rows of numbers are expected"));
        }
        if head.iter().take(4096).any(|&b| b == 0) {
            return Err(Error::at(file, 0, "this is a binary file; delimited text with a header line is expected"));
        }
        let (line, first) = head
            .split(|&b| b == b'\n')
            .enumerate()
            .find(|(_, l)| !l.trim_ascii().is_empty() && !l.trim_ascii_start().starts_with(b"#"))
            .ok_or_else(|| Error::at(file, 0, "only blank lines and comments; a header line is expected"))?;
        let delimiter = delimiter(first);
        let text = Cursor::new(head).chain(text);
        let text: Box<dyn Read + 'a> = match delimiter {
            Some(_) => Box::new(text),
            None => Box::new(Squeezed { text: BufReader::new(text), line: Vec::new(), at: 0 }),
        };
        let mut reader = csv::ReaderBuilder::new()
            .delimiter(delimiter.unwrap_or(b' '))
            .comment(Some(b'#'))
            .trim(csv::Trim::All)
            .flexible(true)
            .from_reader(text);
        let header: Vec<String> = match reader.byte_headers() {
            Ok(h) => h.iter().map(|c| String::from_utf8_lossy(c).into_owned()).collect(),
            Err(e) => return Err(Error::at(file, line + 1, format!("the header cannot be read: {e}"))),
        };
        check_header(file, line + 1, &header)?;
        Ok(TableReader { file: file.into(), header, reader, record: csv::ByteRecord::new(), rows: 0 })
    }

    /// The next rows, at most `most`; none at the end.
    pub fn rows(&mut self, most: usize) -> Result<Table, Error> {
        let mut table = Table {
            file: self.file.clone(),
            columns: vec![Vec::new(); self.header.len()],
            texts: vec![None; self.header.len()],
            header: self.header.clone(),
            skipped: self.rows,
            ..Table::default()
        };
        while table.rows() < most {
            let line = self.reader.position().line() as usize;
            match self.reader.read_byte_record(&mut self.record) {
                Ok(false) => break,
                Ok(true) => {
                    let line = self.record.position().map_or(line, |p| p.line() as usize);
                    push(&mut table, line, &self.record);
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
}

fn unreadable(file: &str, line: usize, e: &std::io::Error) -> Error {
    match e.kind() {
        // The ways in which a decoder says that its input is none.
        std::io::ErrorKind::InvalidInput | std::io::ErrorKind::InvalidData | std::io::ErrorKind::UnexpectedEof => {
            Error::at(file, line, format!("the gzip stream is damaged or cut short: {e}"))
        }
        _ => Error::at(file, line, format!("cannot be read: {e}")),
    }
}

fn push(table: &mut Table, line: usize, record: &csv::ByteRecord) {
    table.ragged += usize::from(record.len() != table.header.len());
    table.lines.push(line);
    for (c, column) in table.columns.iter_mut().enumerate() {
        let cell = record.get(c).unwrap_or(b"");
        let x = std::str::from_utf8(cell).ok().and_then(number);
        if x.is_none() && table.texts[c].is_none() {
            table.texts[c] = Some((line, String::from_utf8_lossy(cell).into_owned()));
        }
        column.push(x.unwrap_or(f64::NAN));
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
            if self.text.read_until(b'\n', &mut line)? == 0 {
                return Ok(0);
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
fn number(cell: &str) -> Option<f64> {
    match cell.parse::<f64>() {
        Ok(x) => Some(x),
        Err(_) if matches!(cell.to_ascii_lowercase().as_str(), "" | "na" | "n/a" | "null" | "none" | "-" | "?") => {
            Some(f64::NAN)
        }
        Err(_) => None,
    }
}

fn delimiter(line: &[u8]) -> Option<u8> {
    [b',', b';', b'\t'].into_iter().find(|d| line.contains(d))
}

/// Refuses headers that name no columns, or too many, or one twice; `line` is where they stand.
pub fn check_header(file: &str, line: usize, header: &[String]) -> Result<(), Error> {
    let at = |message: String| Err(Error::at(file, line, message));
    if header.len() > MAX_COLUMNS {
        return at(format!("{} columns; at most {MAX_COLUMNS} are expected", header.len()));
    }
    if header.iter().all(|h| h.parse::<f64>().is_ok()) {
        return at("the first line holds numbers; a header with the names of the columns is expected".into());
    }
    for (i, name) in header.iter().enumerate() {
        if !name.is_empty() && header[..i].contains(name) {
            return at(format!("two columns are named `{name}`; every column needs a name of its own"));
        }
    }
    Ok(())
}
