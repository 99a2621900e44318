//! Wing: motions from other programs, read and evaluated.
//!
//! A ROS JointTrajectory, or a table of points, becomes a motion that `rist check` verifies; and for any motion or log, the wing
//! predicts what an identification from it would determine.
//!
//! What the core promises this wing: `rist::wings` asks for points where a file is no motion and no plan of rist; `experiments`
//! interpolates points, and predicts standard deviations from a motion.

#![warn(missing_docs)]

mod points;
mod predicted_accuracy;
mod request;

pub use points::{points_of_ros, points_of_table};
pub use predicted_accuracy::{JointForecast, PredictedAccuracy, predicted_accuracy};
pub use request::{VisibilityRequest, wing};
