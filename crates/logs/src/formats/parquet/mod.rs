//! Parquet: columns in compressed pages.

pub mod file;
pub mod pages;
pub mod thrift;
