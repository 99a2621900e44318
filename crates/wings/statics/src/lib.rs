//! Wing for statics: gravity parameters from postures that a robot holds, and a load from a force-torque sensor after the last
//! joint.
//!
//! Parts of the core that this wing uses: `logs` reads tables and finds columns by their names. `modeling` derives the gravity
//! torque and its independent columns. `identification` provides the hypotheses on faults and the changes of a log that correct
//! these faults (`estimate::hypothesis`, `estimate::log_check::Change`), claims, and the rule for the level of trust. `rist` has
//! the model, the orientation of its base, and the text of a load.

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
