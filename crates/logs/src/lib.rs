//! Reads log files and converts them to logs: measured joint signals over time, cleaned, with a report on the cleaning.
//!
//! The steps: file -> [`Table`] (named columns of numbers) -> [`Columns`] (mapping from columns to signals) -> [`Log`] in memory,
//! or [`LogStream`] block by block. This crate has no robot model: coordinates are only names.

#![warn(missing_docs)]

mod ahead;
mod cleaning;
mod columns;
mod effort;
mod error;
mod file_state;
mod formats;
mod integers;
mod joined;
mod log;
mod packed;
mod parallel_series;
mod part;
mod postures;
mod read;
mod stream;
mod table;
mod timeline;

pub use cleaning::account::{LeftOutRows, LogReport};
pub use cleaning::clock::{Clock, GAP_PERIODS};
pub use cleaning::goals::GoalSpan;
pub use cleaning::raw_words::RawWord;
pub use cleaning::refresh::Refresh;
pub use cleaning::rest::RestTimes;
pub use cleaning::suspects::Suspect;
pub use cleaning::turns::{extremes, unwrap_angle};
pub use cleaning::undriven::NoTorqueReason;
pub use columns::mapping::Columns;
pub use columns::names::{ColumnNames, NamePattern};
pub use columns::proposal::{Proposal, Proposed, propose};
pub use columns::source::ColumnSource;
pub use columns::units::UnitNames;
pub use columns::words::Quantity;
pub use effort::Effort;
pub use error::Error;
pub use formats::arrays::Array;
pub use formats::cells::Cells;
pub use formats::registered::format_names;
pub use formats::written::parquet_bytes;
pub use log::{Log, Window};
pub use postures::Postures;
pub use stream::{LogSource, LogStream};
pub use table::{Lines, Table};

/// The types with which another package can add a file format.
pub mod reading {
    pub use gate::budget::Budget;

    pub use crate::columns::words::is_clock;
    pub use crate::formats::compression::Compression;
    pub use crate::formats::json::add_document;
    pub use crate::formats::message::{Channel, Message, ReadOutcome, Receiver};
    pub use crate::formats::number::number;
    pub use crate::formats::records::{Records, named};
    pub use crate::formats::registered::{
        LogFormat, LogReader, ReadBytes, ReadMessages, RowIterator, WantedChannels, register,
    };
    pub use crate::formats::stored_number::{NumberType, Numbers, time_note, without_unit};
    pub use crate::formats::text_head::{IsShape, TextHead, rows};
    pub use crate::table::{MAX_CELLS, MAX_COLUMNS, MAX_FILE_BYTES, RowReader, check_header};
}
