//! Wing: motions of others, read and looked at.
//!
//! A JointTrajectory of ROS, or a table of points, becomes a motion that a check proves; and of any motion or log it is said what an
//! identification from it would determine.
//!
//! What the core promises this wing: `rist::wings` asks for points where a file is no motion and no plan of rist; `experiments`
//! goes through points, and predicts deviations from a motion.

#![warn(missing_docs)]

mod points;
mod request;
mod told_by;

pub use points::{points_of_ros, points_of_table};
pub use request::{VisibilityRequest, wing};
pub use told_by::{Outlook, ToldBy, told_by};
