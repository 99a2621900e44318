//! Log formats that other packages read. They must be registered before the first file is opened.
//!
//! A format is recognised by its first bytes (magic bytes) or, for text, by its first rows. A recording is a file with messages
//! of ROS. The budget is the memory that a file may use; decompressed bytes are taken from it.

use std::io::Read;
use std::path::Path;
use std::sync::OnceLock;

use gate::budget::Budget;
use gate::source::RandomAccessFile;

use crate::Error;
use crate::formats::message::{Channel, ReadOutcome, Receiver};
use crate::formats::text_head::IsShape;
use crate::table::{RowReader, Table};

/// A format of log files.
#[derive(Clone, Copy)]
pub struct LogFormat {
    /// Name of the format for lists. Formats with the same name appear only once.
    pub name: &'static str,
    /// The first bytes of files of this format. For a format in a zip: the name of a file that occurs only in zips of this
    /// format.
    pub magic: &'static [u8],
    /// The reader of the format.
    pub reader: LogReader,
}

/// A function that reads a table from bytes. Arguments: file name, bytes, and the budget from which decompressed bytes are taken.
pub type ReadBytes = fn(&str, &[u8], &mut Budget) -> Result<Table, Error>;

/// A function that selects the channels of a recording.
pub type WantedChannels<'a> = dyn Fn(&Channel) -> bool + 'a;

/// A function that passes the messages of a recording to a receiver. Decompressed bytes are taken from the budget.
pub type ReadMessages<Of> = fn(&Of, &WantedChannels, &mut Budget, &mut Receiver) -> Result<ReadOutcome, String>;

/// A reader of rows, or the error why the file cannot be opened.
pub type RowIterator<'a> = Result<Box<dyn RowReader + 'a>, Error>;

/// How files of a format are read.
#[derive(Clone, Copy)]
pub enum LogReader {
    /// The whole file is read into memory.
    Whole(ReadBytes),
    /// The file has an index at its end, and some rows are read at a time. A file on disk is read by position.
    Indexed {
        /// Opens a file on disk. Arguments: file name and file.
        of_file: fn(&str, RandomAccessFile) -> RowIterator<'static>,
        /// Reads a file from memory if it came through a pipe.
        of_bytes: ReadBytes,
    },
    /// Some rows are read at a time, from the start of the file to its end.
    Stream {
        /// Opens a stream. Arguments: file name and stream.
        of_source: for<'a> fn(&str, Box<dyn Read + Send + 'a>) -> RowIterator<'a>,
        /// Reads a stream from memory after it was decompressed.
        of_bytes: ReadBytes,
    },
    /// A text format that is recognised by its first rows, because it has no magic bytes.
    Text {
        /// Whether a text has this shape.
        is_so: IsShape,
        /// Reads the text.
        read: ReadBytes,
    },
    /// The file contains the messages of a ROS recording.
    Recording {
        /// Reads the messages of a file on disk.
        of_file: ReadMessages<Path>,
        /// Reads the messages from memory after the file was decompressed.
        of_bytes: ReadMessages<[u8]>,
    },
    /// There is no reader for this format.
    Absent {
        /// A description of such a file, and a remedy.
        what: &'static str,
        /// Whether such a file contains messages of a recording. If so, a folder with this file is refused, because a part of
        /// the recording would be missing.
        is_recording: bool,
    },
}

static FORMATS: OnceLock<Vec<LogFormat>> = OnceLock::new();

/// Registers formats. Only the first call has an effect.
pub fn register(formats: Vec<LogFormat>) {
    FORMATS.get_or_init(|| formats);
}

/// Formats that this package reads. Parquet and LeRobot need the feature `parquet`.
const CORE_FORMATS: [&str; 7] = ["CSV", ".npz", "JSON", "MCAP", "rosbag2 directories", "Parquet", "LeRobot"];

/// The names of all formats that this program reads, each once.
pub fn format_names() -> Vec<&'static str> {
    let is_built = |name: &&str| cfg!(feature = "parquet") || !["Parquet", "LeRobot"].contains(name);
    let mut names: Vec<&str> = CORE_FORMATS.into_iter().filter(is_built).collect();
    let is_read = |format: &&LogFormat| !matches!(format.reader, LogReader::Absent { .. });
    names.extend(FORMATS.get().into_iter().flatten().filter(is_read).map(|format| format.name));
    names.dedup();
    names
}

/// The index of the format with these first bytes; `None` if no registered format has them.
pub(crate) fn of_head(head: &[u8]) -> Option<usize> {
    FORMATS.get()?.iter().position(|format| !format.magic.is_empty() && head.starts_with(format.magic))
}

/// For each registered text format: the function that recognises it, and the function that reads it.
pub(crate) fn text_shapes() -> impl Iterator<Item = (IsShape, ReadBytes)> {
    FORMATS.get().into_iter().flatten().filter_map(|format| match format.reader {
        LogReader::Text { is_so, read } => Some((is_so, read)),
        _ => None,
    })
}

/// The reader for a zip that contains these files; `None` if no registered format has one of these file names.
pub(crate) fn of_members(members: &[&str]) -> Option<LogReader> {
    let is_of = |format: &&LogFormat| members.iter().any(|member| member.as_bytes() == format.magic);
    FORMATS.get()?.iter().find(is_of).map(|format| format.reader)
}

/// The reader for an index without a format.
const UNKNOWN: LogReader = LogReader::Absent { what: "unknown", is_recording: false };

/// The reader of the format with an index from [`of_head`].
pub(crate) fn reader(place: usize) -> LogReader {
    FORMATS.get().map_or(UNKNOWN, |formats| formats[place].reader)
}
