//! Recordings of ROS: messages in MCAP files and rosbag2 directories.
//!
//! `mcap` reads the messages of a file, `cdr` and `schema` decode messages, `recording` selects the topic, and the tables are
//! made by `joint_table` (joint states) or `message_table` (any other type).

pub(crate) mod cdr;
pub(crate) mod fields;
pub(crate) mod joint_state;
pub(crate) mod joint_table;
pub(crate) mod mcap;
pub(crate) mod message_table;
pub(crate) mod recording;
pub(crate) mod schema;
