//! The file formats of logs, one reader each.

pub(crate) mod arrays;
mod assignments;
mod cell_ends;
pub(crate) mod cells;
pub(crate) mod compression;
pub(crate) mod content;
pub(crate) mod delimited;
mod documents;
pub(crate) mod json;
pub(crate) mod lerobot;
mod list_cells;
pub(crate) mod message;
pub(crate) mod npz;
mod number;
#[cfg(feature = "parquet")]
pub(crate) mod parquet;
mod per_joint;
mod plain_rows;
mod records;
pub(crate) mod registered;
pub(crate) mod rosbag;
mod rows;
pub(crate) mod stored_number;
pub(crate) mod text_shapes;
pub(crate) mod written;
