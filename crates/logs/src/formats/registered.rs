//! Formats that other packages read; they are registered before the first file is opened.

use std::io::Read;
use std::path::Path;
use std::sync::OnceLock;

use gate::budget::Budget;
use gate::source::RandomAccessFile;

use crate::Error;
use crate::formats::message::{Channel, ReadOutcome, Receiver};
use crate::table::{RowReader, Table};

/// A format of log files.
#[derive(Clone, Copy)]
pub struct LogFormat {
    /// Name of the format in lists; formats with the same name count as one.
    pub name: &'static str,
    /// The first bytes of its files; of a format in a zip, the name of a file that only its zips have.
    pub magic: &'static [u8],
    /// Its reader.
    pub reader: LogReader,
}

/// Reads a table from the bytes of a file with this name; decompressed bytes are drawn from the budget.
pub type ReadBytes = fn(&str, &[u8], &mut Budget) -> Result<Table, Error>;

/// Selects channels of a recording.
pub type WantedChannels<'a> = dyn Fn(&Channel) -> bool + 'a;

/// Passes messages of a recording to a receiver; decompressed bytes are drawn from the budget.
pub type ReadMessages<Of> = fn(&Of, &WantedChannels, &mut Budget, &mut Receiver) -> Result<ReadOutcome, String>;

/// Rows that are read on demand.
pub type RowIterator<'a> = Result<Box<dyn RowReader + 'a>, Error>;

/// The reader of a format.
#[derive(Clone, Copy)]
pub enum LogReader {
    /// From a file in memory.
    Whole(ReadBytes),
    /// Some rows at a time, by the index at the end of a file on disk.
    Indexed {
        /// The rows of the file with this name.
        of_file: fn(&str, RandomAccessFile) -> RowIterator<'static>,
        /// Reads a file that came through a pipe.
        of_bytes: ReadBytes,
    },
    /// Some rows at a time, in sequence.
    Stream {
        /// The rows of the stream with this name.
        of_source: for<'a> fn(&str, Box<dyn Read + Send + 'a>) -> RowIterator<'a>,
        /// Reads a stream that was decompressed.
        of_bytes: ReadBytes,
    },
    /// The messages of a recording of ROS.
    Recording {
        /// The messages of a file.
        of_file: ReadMessages<Path>,
        /// The messages of a file that was decompressed.
        of_bytes: ReadMessages<[u8]>,
    },
    /// No reader.
    Absent {
        /// The description of such a file, and the remedy.
        what: &'static str,
        /// Whether it contains messages of a recording, and may not be missing from a folder of parts.
        is_recording: bool,
    },
}

static FORMATS: OnceLock<Vec<LogFormat>> = OnceLock::new();

/// Adds formats; only the first call counts.
pub fn register(formats: Vec<LogFormat>) {
    FORMATS.get_or_init(|| formats);
}

/// Formats of this package, in the order of use. Parquet is a feature, which LeRobot needs too.
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

/// The index of the format with these first bytes.
pub(crate) fn of_head(head: &[u8]) -> Option<usize> {
    FORMATS.get()?.iter().position(|format| head.starts_with(format.magic))
}

/// The reader of a zip with these files; `None`: no format has one of them.
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
