//! Parquet: columns in compressed pages.
//!
//! `file` reads a whole file, `column` one column, and `pages` decompresses pages. `write` writes a table.

pub(crate) mod column;
pub(crate) mod file;
pub(crate) mod file_bytes;
pub(crate) mod number;
pub(crate) mod pages;
pub(crate) mod schema_guard;
pub(crate) mod split_values;
pub(crate) mod write;
