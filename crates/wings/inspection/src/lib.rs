//! Wing (optional package) for inspection: reads and evaluates motions from other programs.
//!
//! A ROS JointTrajectory or a table of points becomes a motion that `rist check` can verify. For any motion or log, the wing
//! predicts which parameters an identification would determine, and how accurately.
//!
//! Parts of the core that this wing uses: `rist::wings` calls this wing if a file is neither a motion nor a plan of rist.
//! `experiments` interpolates points, and predicts standard deviations from a motion.

#![warn(missing_docs)]

mod points;
mod predicted_accuracy;
mod request;

pub use points::{points_of_ros, points_of_table};
pub use predicted_accuracy::{JointForecast, PredictedAccuracy, predicted_accuracy};
pub use request::{VisibilityRequest, wing};
