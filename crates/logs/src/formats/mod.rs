//! The formats that logs come in, one reader each.

pub(crate) mod arrays;
#[cfg(feature = "arrow")]
pub(crate) mod arrow;
mod cell_ends;
pub(crate) mod cells;
#[cfg(feature = "zstd")]
pub(crate) mod compression;
pub(crate) mod content;
pub(crate) mod delimited;
pub(crate) mod lerobot;
#[cfg(feature = "mat")]
pub(crate) mod mat;
#[cfg(feature = "npz")]
pub(crate) mod npz;
mod number;
#[cfg(feature = "parquet")]
pub(crate) mod parquet;
mod plain_rows;
#[cfg(any(feature = "mcap", feature = "rosbag2-sqlite"))]
pub(crate) mod rosbag;
mod rows;
#[cfg(any(feature = "arrow", feature = "parquet"))]
pub(crate) mod stored_number;
pub(crate) mod written;
