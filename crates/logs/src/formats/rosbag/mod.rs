//! Recordings of ROS: messages in MCAP files and rosbag2 directories.

pub(crate) mod cdr;
pub(crate) mod fields;
pub(crate) mod joint_state;
pub(crate) mod joint_table;
pub(crate) mod mcap;
pub(crate) mod message_table;
pub(crate) mod recording;
pub(crate) mod schema;
