//! Recordings of ROS: joint states in MCAP files and rosbag2 directories.

pub mod joint_state;
pub mod mcap;
pub mod recording;
