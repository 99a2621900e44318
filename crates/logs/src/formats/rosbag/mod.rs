//! Recordings of ROS: joint states in MCAP files and rosbag2 directories.

pub(crate) mod joint_state;
pub(crate) mod joint_table;
#[cfg(feature = "mcap")]
pub(crate) mod mcap;
pub(crate) mod message;
pub(crate) mod recording;
#[cfg(feature = "rosbag2-sqlite")]
pub(crate) mod sqlite;
