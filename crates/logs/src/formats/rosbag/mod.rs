//! Recordings of ROS: joint states in MCAP files and rosbag2 directories.

pub mod joint_state;
pub mod joint_table;
#[cfg(feature = "mcap")]
pub mod mcap;
pub mod message;
pub mod recording;
#[cfg(feature = "rosbag2-sqlite")]
pub mod sqlite;
