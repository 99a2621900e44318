//! Arrow IPC: files (Feather, version 2) and streams.
//!
//! `messages` divides the bytes into messages, `flatbuffer` and `schema` decode their descriptions, `batch` decodes numbers,
//! and `batches` makes tables of some rows at a time.

mod batch;
mod batches;
mod flatbuffer;
pub(crate) mod messages;
mod schema;

use gate::budget::Budget;
use logs::reading::{LogReader, RowReader};
use logs::{Error, Table};

use crate::arrow::batches::ArrowReader;

/// The reader of Arrow files.
pub(crate) const FILE: LogReader = LogReader::Indexed {
    of_file: |file, pieces| {
        let length = pieces.length();
        Ok(Box::new(ArrowReader::of_file(file, Box::new(move |at, count| pieces.read(at, count)), length)?))
    },
    of_bytes,
};

/// The reader of Arrow streams.
pub(crate) const STREAM: LogReader =
    LogReader::Stream { of_source: |file, source| Ok(Box::new(ArrowReader::of_stream(file, source)?)), of_bytes };

/// Reads all rows of a file or a stream whose content is in memory.
fn of_bytes(file: &str, bytes: &[u8], _: &mut Budget) -> Result<Table, Error> {
    ArrowReader::of_bytes(file, bytes)?.rows(usize::MAX)
}
