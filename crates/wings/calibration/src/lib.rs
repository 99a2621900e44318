//! Wing for kinematic calibration: errors of the geometry, zeros and compliances of a robot from measured poses, points and
//! distances.
//!
//! Parts of the core that this wing uses: `logs` reads tables and finds the columns of the joints. `modeling` has the rule for
//! independent columns. `numerics` has Student's distribution. `rist` has the model, its holding torques and the editing of a
//! URDF. `claims` and `identification` have the rule for the level of trust.

#![warn(missing_docs)]

mod base_geometry;
mod calibrate;
mod chain;
mod corrections;
mod design;
mod determined;
mod fit;
mod folds;
mod gears;
#[cfg(test)]
mod laws;
mod level;
mod measurement;
mod mistakes;
mod page;
mod parameter;
mod pose_table;
mod report;
mod request;
#[cfg(test)]
mod simulated;
mod start;
mod torques;
mod verdict;
mod write_back;

pub use base_geometry::{ExactGeometry, GeometricBase, geometric_base};
pub use calibrate::{CalibratedParameter, Calibration, HoldingTorque, calibrate, calibrate_table, chain_of};
pub use chain::{Chain, Convention, Derivatives, Placed, Twist};
pub use corrections::{CalibrationOptions, MeasurementColumns, TableCorrections};
pub use design::{DESIGN_NOISE, Design, Determined, design};
pub use fit::{Fit, Noise};
pub use folds::PredictionError;
pub use level::Level;
pub use measurement::{Linearised, MeasurementKind, Posture, Problem, ResidualKind, Unknowns};
pub use mistakes::Mistake;
pub use parameter::{Letter, NamedParameter, Parameter, ParameterGroup, ParameterNames};
pub use pose_table::{PoseTable, Touched};
pub use report::inspected;
pub use request::{CalibrateRequest, Calibrated, ErrorNames, Measured, wing};
pub use torques::{calibrate_model, holding_torque};
pub use verdict::CalibrationVerdict;
pub use write_back::{calibrated_urdf, calibrated_yaml, ur_kinematics, zeros_table};
