//! Wing: what rest says of bodies and loads. Gravity's parameters from postures that a robot holds, and a load from a force-torque sensor
//! behind the last joint.
//!
//! What the core promises this wing: `logs` has tables and finds columns by their names; `modeling` the gravity torque and its independent
//! columns; `identification` hypotheses that are undone (`estimate::hypothesis`, `estimate::passport::Change`), claims and the rule of
//! trust; `rist` the model, the mount of its base and the text of a load.

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
