//! The assignment of columns to signals.
//!
//! `words` interprets headers, `finder` finds the columns of each quantity, `mapping` combines them to the mapping
//! (`mapping::Columns`: the column of each signal of each joint), and `proposal` proposes names and units if a mapping cannot
//! be found.

pub(crate) mod clocks;
pub(crate) mod finder;
pub(crate) mod mapping;
pub(crate) mod names;
pub(crate) mod prefixes;
pub(crate) mod proposal;
pub(crate) mod relations;
pub(crate) mod row_rate;
pub(crate) mod slope;
pub(crate) mod source;
pub(crate) mod units;
pub(crate) mod words;
