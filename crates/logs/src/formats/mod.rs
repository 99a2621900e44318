//! The file formats of logs, one reader each.
//!
//! A reader takes bytes or a file, and returns a table of named columns. `content` determines the format.

pub(crate) mod arrays;
mod cell_ends;
pub(crate) mod cells;
pub(crate) mod compression;
pub(crate) mod content;
pub(crate) mod delimited;
pub(crate) mod json;
pub(crate) mod lerobot;
pub(crate) mod message;
pub(crate) mod npy;
pub(crate) mod npz;
pub(crate) mod number;
#[cfg(feature = "parquet")]
pub(crate) mod parquet;
mod plain_rows;
pub(crate) mod records;
pub(crate) mod registered;
pub(crate) mod rosbag;
mod rows;
pub(crate) mod stored_number;
pub(crate) mod text_head;
pub(crate) mod text_shapes;
pub(crate) mod unpacked;
pub(crate) mod written;
