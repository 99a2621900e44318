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
//!   write_urdf, write_mjcf_joints                          (back into what simulators read)
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
//! `examples/` has the five things people do: inspect a robot, identify a log, run a generated file in a control loop,
//! plan and validate experiments, convert a description and write identified bodies back.

#![warn(missing_docs)]

mod after_estimate;
mod checking;
mod described;
mod description;
mod doctor;
mod error;
mod evaluation;
mod excite_request;
mod excite_timing;
mod exciting;
mod experiments;
mod fleet;
mod load;
mod model;
mod output;
mod page;
mod planning;
mod regressor_slope;
mod samples;
mod simulation;
mod source;
mod surroundings;
mod tape_dynamics;
mod tape_regressor;
mod thread_tapes;
mod torque_difference;
mod torque_enclosure;
mod validation;
mod verdict;
mod write_back;

pub use checking::{Checked, check};
pub use description::{ModelOptions, RotorInertias, check_values, parse_robot, read_robot, snapping};
pub use doctor::examine;
pub use error::Error;
pub use evaluation::{Evaluation, ManyStates, Quantity};
pub use excite_request::ExciteRequest;
pub use excite_timing::default_period;
pub use exciting::{ExciteProgress, excite};
pub use experiments::{ExperimentLogs, identify_experiments};
pub use fleet::{AccumulateRequest, accumulate, accumulator, check_sums, update};
pub use identification::algebra::interruption::Interruption;
pub use identification::estimate::artefact::Estimate;
pub use identification::estimate::fleet::accumulator::Accumulator;
pub use identification::estimate::fleet::comparison::{Comparison, compare};
pub use identification::estimate::passport::Passport;
pub use identification::estimate::validation::Validation;
pub use identification::estimate::verdict::{Trust, Verdict};
pub use identification::experiments::excitation::artefact::ExcitingMotion;
pub use identification::experiments::experiment_plan::ExperimentPlan;
pub use identification::portrait::Portrait;
pub use identification::portrait::series::{TorqueSeries, series_to_csv};
pub use load::Load;
pub use logs::LogSource;
pub use model::{Model, base_columns};
pub use output::{check_output, is_same, write_file};
pub use page::{Origin, PageRequest, page};
pub use planning::{PlanRequest, Planned, plan, plan_candidates};
pub use samples::{Bodies, Identification, IdentifyRequest, identify};
pub use simulation::{Motions, SimulateRequest, Simulated, simulate};
pub use source::{Language, Source, function_named, function_names, generate};
pub use torque_difference::torque_difference;
pub use validation::{MOTION_CUTOFF, portrait, predicted_torques, predictions, validate, validate_experiments};
pub use verdict::{estimate_verdict, fitted_verdict, predicted_verdict, validation_verdict};
pub use write_back::{write_mjcf_joints, write_urdf};
