//! Formats that other packages read: registered before the first file is opened.

use std::io::Read;
use std::path::Path;
use std::sync::OnceLock;

use gate::budget::Budget;
use gate::source::Pieces;

use crate::Error;
use crate::formats::message::{Channel, Outcome, Receiver};
use crate::table::{RowReader, Table};

/// A format of log files.
#[derive(Clone, Copy)]
pub struct LogFormat {
    /// Its name in lists of formats; formats of one name count as one.
    pub name: &'static str,
    /// The first bytes of its files.
    pub magic: &'static [u8],
    /// What reads it.
    pub reader: LogReader,
}

/// A table of the bytes of the file named; what is unpacked is drawn from the budget.
pub type ReadBytes = fn(&str, &[u8], &mut Budget) -> Result<Table, Error>;

/// Which channels of a recording are wanted.
pub type Wanted<'a> = dyn Fn(&Channel) -> bool + 'a;

/// Hands messages of a recording to a receiver; what is unpacked is drawn from the budget.
pub type ReadMessages<Of> = fn(&Of, &Wanted, &mut Budget, &mut Receiver) -> Result<Outcome, String>;

/// Rows that are read on demand.
pub type Rows<'a> = Result<Box<dyn RowReader + 'a>, Error>;

/// How files of a format are read.
#[derive(Clone, Copy)]
pub enum LogReader {
    /// From a file that is held whole.
    Whole(ReadBytes),
    /// Some rows at a time, by the index at the end of a file on disk.
    Indexed {
        /// The rows of the file named.
        of_file: fn(&str, Pieces) -> Rows<'static>,
        /// The same for a file that came through a pipe.
        of_bytes: ReadBytes,
    },
    /// Some rows at a time, in their order.
    Stream {
        /// The rows of the stream named.
        of_source: for<'a> fn(&str, Box<dyn Read + Send + 'a>) -> Rows<'a>,
        /// The same for a stream that was unpacked.
        of_bytes: ReadBytes,
    },
    /// The messages of a recording of ROS.
    Recording {
        /// The messages of a file.
        of_file: ReadMessages<Path>,
        /// The same for a file that was unpacked.
        of_bytes: ReadMessages<[u8]>,
    },
    /// Nothing.
    Absent {
        /// What such a file is, and what to do.
        what: &'static str,
        /// Whether it holds messages of a recording, which a folder of parts may not lose.
        is_recording: bool,
    },
}

static FORMATS: OnceLock<Vec<LogFormat>> = OnceLock::new();

/// Adds formats; only the first call counts.
pub fn register(formats: Vec<LogFormat>) {
    FORMATS.get_or_init(|| formats);
}

/// Formats that are read here, in the order of use. Parquet is a feature, which LeRobot needs too.
const CORE: [&str; 6] = ["CSV", ".npz", "MCAP", "rosbag2 directories", "Parquet", "LeRobot"];

/// The names of all formats that this program reads, each once.
pub fn format_names() -> Vec<&'static str> {
    let is_built = |name: &&str| cfg!(feature = "parquet") || !["Parquet", "LeRobot"].contains(name);
    let mut names: Vec<&str> = CORE.into_iter().filter(is_built).collect();
    let is_read = |format: &&LogFormat| !matches!(format.reader, LogReader::Absent { .. });
    names.extend(FORMATS.get().into_iter().flatten().filter(is_read).map(|format| format.name));
    names.dedup();
    names
}

/// The place of the format whose files begin so.
pub(crate) fn of_head(head: &[u8]) -> Option<usize> {
    FORMATS.get()?.iter().position(|format| head.starts_with(format.magic))
}

/// Of a place that no format has.
const UNKNOWN: LogReader = LogReader::Absent { what: "unknown", is_recording: false };

/// What reads the format at a place that [`of_head`] gave.
pub(crate) fn reader(place: usize) -> LogReader {
    FORMATS.get().map_or(UNKNOWN, |formats| formats[place].reader)
}
