//! Parquet: columns in compressed pages.

pub mod file;
pub mod number;
pub mod pages;
pub mod schema_guard;
pub mod split_values;
pub mod write;
