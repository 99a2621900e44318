//! Reads logs in text formats that are no plain tables.
//!
//! Each file recognises one shape of text by its first rows, and reads such a text as a table.

use logs::reading::{LogFormat, LogReader};

mod assignments;
mod documents;
mod list_cells;
mod per_joint;

/// The formats, in the order in which they are tried.
pub(crate) const SHAPES: [LogFormat; 5] = [
    shape("`ros2 topic echo`", documents::is_yaml, documents::read_yaml),
    shape("XML of RSI", documents::is_xml, documents::read_xml),
    shape("text in other shapes", assignments::is_so, assignments::read),
    shape("text in other shapes", list_cells::is_so, list_cells::read),
    shape("text in other shapes", per_joint::is_so, per_joint::read),
];

const fn shape(name: &'static str, is_so: logs::reading::IsShape, read: logs::reading::ReadBytes) -> LogFormat {
    LogFormat { name, magic: b"", reader: LogReader::Text { is_so, read } }
}

#[cfg(test)]
fn table(text: &str) -> Result<logs::Table, logs::Error> {
    logs::reading::register(SHAPES.into());
    logs::Table::from_bytes("x", text.as_bytes())
}
