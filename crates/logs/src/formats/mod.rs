//! The formats that logs come in, one reader each.

pub mod arrays;
#[cfg(feature = "zstd")]
pub mod compression;
pub mod content;
pub mod delimited;
#[cfg(feature = "npz")]
pub mod npz;
mod number;
#[cfg(feature = "parquet")]
pub mod parquet;
#[cfg(any(feature = "mcap", feature = "rosbag2-sqlite"))]
pub mod rosbag;
mod rows;
