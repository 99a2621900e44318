//! A file of named columns of numbers, before anybody says what they mean.
//!
//! Delimited text (comma, semicolon, tab or blanks; `#` starts a comment line; one header line),
//! plain or gzip; the arrays of a .npz (`npz`); a Parquet file (`parquet`); the joint states of a ROS
//! recording (`rosbag`). Which it is says the content, not the name. What a cell means, and which rows
//! are usable, is for `log` to say.

use std::io::Read;
use std::path::Path;

use crate::Error;
use crate::{mcap, npz, parquet, rosbag};

/// Named columns of one length. A cell that is empty, missing or no number is NaN.
#[derive(Clone, Debug, Default)]
pub struct Table {
    /// The file as the user named it.
    pub file: String,
    pub header: Vec<String>,
    /// `columns[c][r]`: column c, row r.
    pub columns: Vec<Vec<f64>>,
    /// The line of the file each row stands on, from 1; empty for files without lines.
    pub lines: Vec<usize>,
    /// For each column the first cell that holds text: its line and the text.
    pub texts: Vec<Option<(usize, String)>>,
    /// Rows with fewer or more cells than the header.
    pub ragged: usize,
    /// What was read and what was not, in a sentence each, where the file leaves a choice.
    pub notes: Vec<String>,
}

/// More columns than this is not a log of a robot.
pub const MAX_COLUMNS: usize = 10_000;

impl Table {
    /// Reads a file, or the directory of a rosbag2; `log.mcap#/topic` names one of several topics.
    pub fn read(path: &Path) -> Result<Table, Error> {
        if let Some(table) = rosbag::read(path) {
            return table;
        }
        let file = path.display().to_string();
        let failed = |e: std::io::Error| Error::at(&file, 0, format!("cannot be read: {e}"));
        let bytes = std::fs::read(path).map_err(failed)?;
        Table::from_bytes(&file, &bytes)
    }

    /// Reads the content of a file; its first bytes say of which kind it is.
    pub fn from_bytes(file: &str, bytes: &[u8]) -> Result<Table, Error> {
        if bytes.is_empty() {
            return Err(Error::at(file, 0, "the file is empty; a header line and rows of numbers are expected"));
        }
        if npz::is_numpy(bytes) {
            return npz::read(file, bytes);
        }
        if parquet::is_parquet(bytes) {
            return parquet::read(file, bytes);
        }
        if bytes.starts_with(mcap::MAGIC) {
            return rosbag::from_bytes(file, bytes);
        }
        if let Some(why) = rosbag::refusal(bytes) {
            return Err(Error::at(file, 0, why));
        }
        if !bytes.starts_with(&[0x1f, 0x8b]) {
            return Table::from_text(file, bytes);
        }
        let mut text = Vec::new();
        flate2::read::MultiGzDecoder::new(bytes)
            .read_to_end(&mut text)
            .map_err(|e| Error::at(file, 0, format!("the gzip stream is damaged or cut short: {e}")))?;
        if text.is_empty() {
            return Err(Error::at(file, 0, "the gzip stream holds nothing; a header line and rows are expected"));
        }
        Table::from_text(file, &text)
    }

    fn from_text(file: &str, bytes: &[u8]) -> Result<Table, Error> {
        let bytes = bytes.strip_prefix("\u{feff}".as_bytes()).unwrap_or(bytes);
        if bytes.iter().take(4096).any(|&b| b == 0) {
            return Err(Error::at(file, 0, "this is a binary file; delimited text with a header line is expected"));
        }
        let (first_line, first) = bytes
            .split(|&b| b == b'\n')
            .enumerate()
            .find(|(_, l)| !l.trim_ascii().is_empty() && !l.trim_ascii_start().starts_with(b"#"))
            .ok_or_else(|| Error::at(file, 0, "only blank lines and comments; a header line is expected"))?;
        let blanks = delimiter(first).is_none();
        let squeezed; // runs of blanks made one, for files separated by blanks
        let bytes = if blanks {
            squeezed = squeeze(bytes);
            &squeezed
        } else {
            bytes
        };
        let mut reader = csv::ReaderBuilder::new()
            .delimiter(delimiter(first).unwrap_or(b' '))
            .comment(Some(b'#'))
            .trim(csv::Trim::All)
            .flexible(true)
            .from_reader(bytes);
        let header: Vec<String> = match reader.byte_headers() {
            Ok(h) => h.iter().map(|c| String::from_utf8_lossy(c).into_owned()).collect(),
            Err(e) => return Err(Error::at(file, first_line + 1, format!("the header cannot be read: {e}"))),
        };
        check_header(file, first_line + 1, &header)?;
        let mut table = Table {
            file: file.into(),
            columns: vec![Vec::new(); header.len()],
            texts: vec![None; header.len()],
            header,
            ..Table::default()
        };
        let mut record = csv::ByteRecord::new();
        loop {
            let line = reader.position().line() as usize;
            match reader.read_byte_record(&mut record) {
                Ok(false) => break,
                Ok(true) => {
                    let line = record.position().map_or(line, |p| p.line() as usize);
                    table.push(line, &record);
                }
                Err(e) => return Err(Error::at(file, line, format!("the row cannot be read: {e}"))),
            }
        }
        Ok(table)
    }

    fn push(&mut self, line: usize, record: &csv::ByteRecord) {
        self.ragged += usize::from(record.len() != self.header.len());
        self.lines.push(line);
        for (c, column) in self.columns.iter_mut().enumerate() {
            let cell = record.get(c).unwrap_or(b"");
            let x = std::str::from_utf8(cell).ok().and_then(number);
            if x.is_none() && self.texts[c].is_none() {
                self.texts[c] = Some((line, String::from_utf8_lossy(cell).into_owned()));
            }
            column.push(x.unwrap_or(f64::NAN));
        }
    }

    pub fn rows(&self) -> usize {
        self.columns.first().map_or(0, Vec::len)
    }

    /// The line of a row, 0 where the file has none.
    pub fn line(&self, row: usize) -> usize {
        self.lines.get(row).copied().unwrap_or(0)
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

fn squeeze(bytes: &[u8]) -> Vec<u8> {
    let mut out = Vec::with_capacity(bytes.len());
    for line in bytes.split(|&b| b == b'\n') {
        let words = line.split(u8::is_ascii_whitespace).filter(|w| !w.is_empty());
        out.extend_from_slice(&words.collect::<Vec<_>>().join(&b' '));
        out.push(b'\n');
    }
    out
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

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Table, Error> {
        Table::from_bytes("log.csv", text.as_bytes())
    }

    #[test]
    fn delimiters_comments_and_gaps() {
        for text in
            ["# made by x\nt,q1\n0,1\n1,\n", "t;q1\n0;1\n1;nan\n", "t\tq1\n0\t1\n1\t\n", "\u{feff}t, q1\n0, 1\n1\n"]
        {
            let table = read(text).unwrap();
            assert_eq!(table.header, ["t", "q1"], "{text:?}");
            assert_eq!(table.columns[0], [0.0, 1.0], "{text:?}");
            assert!(table.columns[1][1].is_nan(), "{text:?}");
        }
        assert_eq!(read("t   q1\n 0  1\n").unwrap().columns, [[0.0], [1.0]]);
        let table = read("t,mode,q1\n0,auto,1\n").unwrap();
        assert_eq!(table.texts[1], Some((2, "auto".into())));
        assert_eq!(table.columns[2], [1.0]);
    }

    #[test]
    fn gzip_by_content() {
        use std::io::Write;
        let mut gz = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
        gz.write_all(b"t,q1\n0,1\n").unwrap();
        let gz = gz.finish().unwrap();
        assert_eq!(Table::from_bytes("log.csv", &gz).unwrap().columns[1], [1.0]);
        let cut = Table::from_bytes("log.csv.gz", &gz[..gz.len() - 6]).unwrap_err().to_string();
        assert!(cut.contains("damaged or cut short"), "{cut}");
    }

    #[test]
    fn refusals_name_the_line() {
        for (text, expected) in [
            ("", "log.csv: the file is empty"),
            ("\n\n", "only blank lines"),
            ("0,1\n2,3\n", "log.csv:1: the first line holds numbers"),
            ("# c\nt,q1,q1\n", "log.csv:2: two columns are named `q1`"),
            ("t,q1\0\n", "binary file"),
        ] {
            let message = read(text).unwrap_err().to_string();
            assert!(message.contains(expected), "{text:?}: {message}");
        }
    }
}
