//! Which format a file has, and its reader.
//!
//! Delimited text (`formats::delimited`), plain or gzip; the arrays of a .npz; a Parquet file; the joint states of a ROS
//! recording. The content decides the format, not the name.

use std::path::Path;

use crate::Error;
use crate::formats::delimited::{GZIP, TableReader};
use crate::formats::npz;
use crate::formats::parquet::file as parquet;
use crate::formats::rosbag::{mcap, recording};
use crate::table::Table;

impl Table {
    /// Reads a file, or the directory of a rosbag2; `log.mcap#/topic` names one of several topics.
    pub fn read(path: &Path) -> Result<Table, Error> {
        if let Some(table) = recording::read(path) {
            return table;
        }
        let file = path.display().to_string();
        let failed = |e: std::io::Error| Error::at(&file, 0, format!("cannot be read: {e}"));
        let bytes = std::fs::read(path).map_err(failed)?;
        Table::from_bytes(&file, &bytes)
    }

    /// Reads the content of a file; its first bytes say of which kind it is.
    pub fn from_bytes(file: &str, bytes: &[u8]) -> Result<Table, Error> {
        if npz::is_numpy(bytes) {
            return npz::read(file, bytes);
        }
        if parquet::is_parquet(bytes) {
            return parquet::read(file, bytes);
        }
        if bytes.starts_with(mcap::MAGIC) {
            return recording::from_bytes(file, bytes);
        }
        if let Some(why) = recording::refusal(bytes) {
            return Err(Error::at(file, 0, why));
        }
        let mut text = if bytes.starts_with(&GZIP) {
            TableReader::new(file, flate2::read::MultiGzDecoder::new(bytes))?
        } else {
            TableReader::new(file, bytes)?
        };
        text.rows(usize::MAX)
    }
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
