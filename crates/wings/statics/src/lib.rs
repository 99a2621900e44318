//! Wing: identification from a robot or a load at rest. Gravity parameters from postures that a robot holds, and a load from a
//! force-torque sensor after the last joint.
//!
//! What the core promises this wing: `logs` has tables and finds columns by their names; `modeling` the gravity torque and its
//! independent columns; `identification` hypotheses and their undoing (`estimate::hypothesis`, `estimate::log_check::Change`),
//! claims and the rule of trust; `rist` the model, the mount of its base and the text of a load.

#![warn(missing_docs)]

pub mod postures;
mod request;
mod wrench;
pub mod wrench_load;
mod wrench_meaning;
mod wrench_options;
mod wrench_turn;
pub mod wrench_verdict;
mod wrenches;

pub use postures::{PostureEstimate, gravity_parameters, identify_postures};
pub use request::{WrenchRequest, wing};
pub use wrench::{WrenchEstimate, identify_wrench};
pub use wrench_options::{Corrections, WrenchColumns, WrenchOptions};
pub use wrenches::Wrenches;
