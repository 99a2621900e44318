//! From a robot description to an exact model, generated code, and inertial parameters identified on the machine.
//!
//! Every step returns what the next one takes:
//!
//! ```text
//! Model::read -> base parameters, regressor, source        (a description is all it needs)
//!   examine(logs) -> Passport                              (whether a log belongs to the description)
//!   identify(logs) -> Estimate -> validate(other logs)     (a log that was measured)
//!   accumulate(logs) -> Accumulator -> merge, solve, compare   (more logs than one machine holds)
//!   excite -> check -> (the robot runs, or simulate)       (one motion, its limits proved)
//!   plan -> simulate -> identify_experiments               (the experiments of spectrum analysis)
//!   write_urdf, write_mjcf                                 (back into what simulators read)
//! ```
//!
//! The base parameters of a robot, and its regressor at one state:
//!
//! ```
//! let models = concat!(env!("CARGO_MANIFEST_DIR"), "/../../models");
//! let model = rist::Model::read(format!("{models}/planar2r_vertical.yaml"))?;
//! let rules = model.parameters.rules();
//! assert_eq!(rules.base[0], "ZZR1 = ZZ1 + IA1 + L1^2*M2");
//!
//! let regressor = model.regressor();
//! let (n, p) = (regressor.coordinates().len(), regressor.parameters().len());
//! let mut y = vec![0.0; n * p];
//! regressor.fill(&[0.1, 0.2], &[0.0, 0.0], &[1.0, 0.0], &mut y);
//! assert_eq!(y[0], 1.0, "the torque of joint 1 per unit of ZZR1 is its acceleration");
//! # Ok::<(), rist::Error>(())
//! ```
//!
//! The root has the steps and what passes between them; each module has what one step takes and returns besides.
//! `examples/` has the five things people do: inspect a robot, identify a log, run a generated file in a control loop,
//! plan and validate experiments, convert a description and write identified bodies back.

#![warn(missing_docs)]

mod adapters;
mod after_estimate;
pub mod checking;
mod chosen;
pub mod closed_loop;
mod described;
pub mod description;
pub mod doctor;
mod drive_gains;
mod effects;
mod error;
pub mod evaluation;
mod excite_timing;
pub mod exciting;
pub mod experiments;
pub mod fleet;
mod formulas;
pub mod judged;
pub mod load;
pub mod model;
pub mod motion_portrait;
mod motion_range;
mod mount;
pub mod output;
pub mod page;
pub mod planning;
pub mod request;
pub mod samples;
pub mod simulation;
pub mod source;
mod symbols;
mod tape;
pub mod torque_difference;
pub mod validation;
pub mod verdict;
pub mod write_back;

pub use checking::check;
pub use description::ModelOptions;
pub use doctor::examine;
pub use error::Error;
pub use exciting::excite;
pub use experiments::identify_experiments;
pub use fleet::{Accumulator, accumulate};
pub use formulas::derive;
pub use identification::estimate::artefact::Estimate;
pub use logs::LogSource;
pub use model::Model;
pub use planning::plan;
pub use samples::{IdentifyRequest, identify};
pub use simulation::simulate;
pub use source::generate;
pub use validation::{Validation, validate};
pub use write_back::steps::write_urdf;
