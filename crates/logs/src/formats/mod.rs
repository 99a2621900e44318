//! The formats that logs come in, one reader each.

pub mod compression;
pub mod delimited;
pub mod npz;
pub mod parquet;
pub mod rosbag;
