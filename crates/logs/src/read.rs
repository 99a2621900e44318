//! Determines the format of a file and opens its reader.
//!
//! The formats are: delimited text (`formats::delimited`), plain or gzip; .npz arrays; Parquet; data sets of LeRobot; ROS
//! recordings; and formats of other packages (`formats::registered`). The content determines the format, not the name. `-` is
//! standard input; `a.csv+b.csv` is one log in two files (`joined`). Text, Parquet on disk and some other formats are read some
//! rows at a time; all other files are read as a whole, up to [`MAX_FILE_BYTES`]. Reading a text stops at
//! [`MAX_CELLS`](crate::table::MAX_CELLS) numbers, so an endless pipe or device is refused.

use std::io::{Cursor, ErrorKind, Read};
use std::path::Path;

use gate::budget::Budget;
use gate::opened;
use gate::source::{RandomAccessFile, Source};

use crate::Error;
use crate::formats::content::{FileFormat, MAGIC_BYTES};
use crate::formats::delimited::{TableReader, unreadable};
use crate::formats::npy;
#[cfg(feature = "parquet")]
use crate::formats::parquet::file::ParquetReader;
use crate::formats::registered::LogReader;
use crate::formats::text_head::HEAD_BYTES;
use crate::formats::text_shapes;
use crate::formats::unpacked::unpacked;
use crate::joined;
use crate::table::{MAX_FILE_BYTES, RowReader, Table};

/// A file that was opened.
pub(crate) enum Opened<'a> {
    /// The rows can be read some at a time.
    Rows {
        reader: Box<dyn RowReader + 'a>,
        /// Whether the file can be opened again; a pipe cannot.
        again: bool,
    },
    /// The file was read as a whole.
    Whole(Table),
}

/// Opens a file, the folder of a rosbag2, or standard input (`-`).
pub(crate) fn open(path: &Path) -> Result<Opened<'static>, Error> {
    if path.as_os_str() == "-" {
        return of_source("standard input", Source::standard_input());
    }
    if let Some(files) = joined::files(path) {
        return joined::read(path, &files).map(Opened::Whole);
    }
    opened::with(path, || open_file(path))
}

fn open_file(path: &Path) -> Result<Opened<'static>, Error> {
    let file = path.display().to_string();
    if let Some(table) = crate::formats::lerobot::read(path)? {
        return Ok(Opened::Whole(table));
    }
    if let Some(table) = crate::formats::rosbag::recording::read(path)? {
        return Ok(Opened::Whole(table));
    }
    let failed = |e: std::io::Error| match e.kind() {
        ErrorKind::NotFound => Error::at(&file, 0, "there is no such file"),
        _ => Error::at(&file, 0, format!("cannot be read: {e}")),
    };
    of_source(&file, Source::open(path).map_err(failed)?)
}

fn of_source(file: &str, mut source: Source) -> Result<Opened<'static>, Error> {
    let failed = |e: std::io::Error| match e.kind() {
        ErrorKind::FileTooLarge => {
            Error::at(file, 0, format!("more than {MAX_FILE_BYTES} bytes; cut the log into parts"))
        }
        _ => Error::at(file, 0, format!("cannot be read: {e}")),
    };
    // A pipe has no length, and cannot be opened a second time.
    let again = source.length().is_some();
    let head = source.head(MAGIC_BYTES).map_err(failed)?;
    let content = FileFormat::of(&head);
    if content.has_index() {
        source = match source.pieces().map_err(failed)? {
            Ok(pieces) => return Ok(Opened::Rows { reader: indexed(file, content, pieces)?, again }),
            Err(pipe) => pipe,
        };
    }
    if content.is_compressed() {
        return of_compressed(file, content, Cursor::new(head).chain(source), again);
    }
    let mut head = head;
    if content == FileFormat::Text {
        head.extend(source.head(HEAD_BYTES - MAGIC_BYTES).map_err(failed)?);
    }
    let is_table = content == FileFormat::Text && text_shapes::reader(&head).is_none();
    // The first bytes were taken from the source, so they are put back in front of it.
    let source = Cursor::new(head).chain(source);
    if let Some(LogReader::Stream { of_source, .. }) = content.reader() {
        return Ok(Opened::Rows { reader: of_source(file, Box::new(source))?, again });
    }
    if is_table {
        return Ok(Opened::Rows { reader: Box::new(TableReader::new(file, source)?), again });
    }
    let bytes = Source::of(source).whole(MAX_FILE_BYTES).map_err(failed)?;
    Table::from_bytes(file, &bytes).map(Opened::Whole)
}

/// Opens a file on disk that has an index of its rows.
fn indexed(file: &str, content: FileFormat, pieces: RandomAccessFile) -> Result<Box<dyn RowReader>, Error> {
    match (content, content.reader()) {
        (_, Some(LogReader::Indexed { of_file, .. })) => of_file(file, pieces),
        #[cfg(feature = "parquet")]
        (FileFormat::Parquet, _) => Ok(Box::new(ParquetReader::of_file(file, pieces)?)),
        _ => Err(Error::at(file, 0, content.refusal().unwrap_or_default())),
    }
}

/// Number of copies in memory of a content that is decompressed as a whole. The copies are in an array that grows by doubling,
/// and in the table.
const COPIES_OF_DECOMPRESSED_BYTES: usize = 4;

/// Opens the content of a gzip or zstd stream: a table of text is read on demand.
fn of_compressed<'a>(
    file: &str,
    format: FileFormat,
    source: impl Read + Send + 'a,
    again: bool,
) -> Result<Opened<'a>, Error> {
    let failed = |e: std::io::Error| match e.kind() {
        ErrorKind::Other => Error::at(file, 0, format!("the compressed stream cannot be unpacked: {e}")),
        _ => unreadable(file, 0, &e),
    };
    let mut source = unpacked(file, format, source)?;
    let mut head = Vec::new();
    source.by_ref().take(MAGIC_BYTES as u64).read_to_end(&mut head).map_err(failed)?;
    let content = FileFormat::of(&head);
    if content.is_compressed() {
        return Err(Error::at(file, 0, "a compressed stream within a compressed stream; unpack it first"));
    }
    // A plain table is read on demand. Its first bytes were taken to determine the format, so they are put back.
    if content == FileFormat::Text {
        source.by_ref().take((HEAD_BYTES - MAGIC_BYTES) as u64).read_to_end(&mut head).map_err(failed)?;
        if text_shapes::reader(&head).is_none() {
            let reader = Box::new(TableReader::unfolding(file, source.put_back(head))?);
            return Ok(Opened::Rows { reader, again });
        }
    }
    // All other contents are decompressed as a whole. The allowed memory grows with the number of compressed bytes, so a small
    // file that expands to a huge content is refused.
    let (packed, mut source) = (source.packed(), source.held(COPIES_OF_DECOMPRESSED_BYTES));
    source.by_ref().take(MAX_FILE_BYTES).read_to_end(&mut head).map_err(failed)?;
    let mut budget = packed.budget();
    budget.draw(2 * head.len()).map_err(|e| Error::at(file, 0, e))?;
    Table::within(file, &head, &mut budget).map(Opened::Whole)
}

impl Table {
    /// Reads a file, the folder of a rosbag2, or standard input (`-`). `log.mcap#/topic` selects one of several topics.
    pub fn read(path: &Path) -> Result<Table, Error> {
        match open(path)? {
            Opened::Rows { mut reader, .. } => reader.rows(usize::MAX),
            Opened::Whole(table) => Ok(table),
        }
    }

    /// Reads at most `most` rows at the start of a file. The path may have any form that [`Table::read`] accepts.
    pub fn glance(path: &Path, most: usize) -> Result<Table, Error> {
        match open(path)? {
            Opened::Rows { mut reader, .. } => reader.rows(most),
            Opened::Whole(table) => Ok(table),
        }
    }

    /// Reads a file from memory. The first bytes determine its format.
    pub fn from_bytes(file: &str, bytes: &[u8]) -> Result<Table, Error> {
        Table::within(file, bytes, &mut Budget::of(bytes.len()))
    }

    /// Reads a file from memory. Decompressed bytes are taken from `budget`.
    fn within(file: &str, bytes: &[u8], budget: &mut Budget) -> Result<Table, Error> {
        let content = FileFormat::of(bytes);
        if let Some(why) = content.refusal() {
            return Err(Error::at(file, 0, why));
        }
        match content.reader() {
            Some(
                LogReader::Whole(of_bytes) | LogReader::Indexed { of_bytes, .. } | LogReader::Stream { of_bytes, .. },
            ) => return of_bytes(file, bytes, budget),
            Some(LogReader::Recording { .. }) => {
                return crate::formats::rosbag::recording::from_bytes(file, bytes, budget);
            }
            Some(LogReader::Text { .. } | LogReader::Absent { .. }) | None => {}
        }
        match content {
            FileFormat::Numpy if bytes.starts_with(npy::MAGIC) => npy::read(file, bytes, budget),
            FileFormat::Numpy => crate::formats::npz::read(file, bytes, budget),
            FileFormat::Json => crate::formats::json::read(file, bytes, budget),
            #[cfg(feature = "parquet")]
            FileFormat::Parquet => crate::formats::parquet::file::read(file, bytes, budget),
            FileFormat::Mcap => crate::formats::rosbag::recording::from_bytes(file, bytes, budget),
            FileFormat::Gzip | FileFormat::Zstd => match of_compressed(file, content, bytes, false)? {
                Opened::Rows { mut reader, .. } => reader.rows(usize::MAX),
                Opened::Whole(table) => Ok(table),
            },
            _ => Table::of_text(file, bytes, budget),
        }
    }

    /// Reads a text: with the reader of its shape (`text_shapes`), or as a table with one row per sample.
    pub(crate) fn of_text(file: &str, bytes: &[u8], budget: &mut Budget) -> Result<Table, Error> {
        match text_shapes::reader(&bytes[..bytes.len().min(HEAD_BYTES)]) {
            Some(read) => read(file, bytes, budget),
            None => TableReader::new(file, bytes)?.rows(usize::MAX),
        }
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
    fn a_file_without_a_header_has_columns_by_place() {
        let table = read("0,1\n2,3\n").unwrap();
        assert_eq!((table.header.join(" "), table.columns), ("c1 c2".into(), vec![vec![0.0, 2.0], vec![1.0, 3.0]]));
        assert!(table.notes[0].contains("no header"), "{:?}", table.notes);
        assert_eq!(read("0\n2\n").unwrap().header, ["c1"]);
        assert_eq!(read("# t q1\n0,1\n").unwrap().header, ["c1", "c2"]);
    }

    #[test]
    fn refusals_name_the_line() {
        for (text, expected) in [("t,q1\0\n", "binary file"), ("# t\n", "only blank lines and comments")] {
            let message = read(text).unwrap_err().to_string();
            assert!(message.contains(expected), "{text:?}: {message}");
        }
    }
}
