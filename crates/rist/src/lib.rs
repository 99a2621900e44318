//! Derives an exact model from a robot description, generates code, and identifies inertial parameters from measurements.
//!
//! Each step returns the input of the next step:
//!
//! ```text
//! Model::read -> base parameters, regressor, source        (a description is all it needs)
//!   examine(logs) -> LogCheck                              (whether a log belongs to the description)
//!   identify(logs) -> Estimate -> validate(other logs)     (a log that was measured)
//!   replay(log) -> Replay                                  (contact, load, drift of friction)
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
//! The root of the crate has the steps with their inputs and results; each module has further types of its step. `examples/`
//! has five frequent tasks: inspect a robot, identify a log, run a generated file in a control loop, plan and validate
//! experiments, convert a description and write identified bodies back.

#![warn(missing_docs)]

pub mod describe;
mod error;
pub mod example;
pub mod fit;
pub mod motion;
pub mod output;
pub mod page;
pub mod replay;
pub mod request;
mod tape;
pub mod wings;
pub mod write_back;

// The steps, each with its request and its result.
pub use describe::conversion::{Converted, convert, inertial_table};
pub use describe::description::{parse_robot, read_robot};
pub use describe::inspection::{Inspection, inspect};
pub use describe::linting::{Lint, lint, lint_with_meshes};
pub use describe::model::Model;
pub use describe::source::generate;
pub use describe::states_file::evaluate;
pub use error::{Error, ErrorKind, Step};
pub use fit::column_proposal::{ColumnProposal, propose_columns};
pub use fit::doctor::{LogCheck, examine};
pub use fit::experiments::{
    ExperimentLogs, identify_experiments, identify_experiments_in_loop, identify_gains_of_rows, identify_paper_rows,
};
pub use fit::hobby_arms::proposed_arm;
pub use fit::samples::{Identification, identify, identify_essential, identify_loaded};
pub use fit::validation::{Validation, predicted_torques, validate};
pub use fit::verdict::{Trust, Verdict};
pub use motion::checking::{Checked, check};
pub use motion::checking_trajectories::{check_experiments, check_points, efficiency_again};
pub use motion::exciting::{ExcitingMotion, excite};
pub use motion::planning::{ExperimentPlan, Planned, plan};
pub use motion::play::PlayFormat;
pub use motion::played_file::{CheckedFile, PlayedFile, ProofCheck, plan_proof};
pub use motion::simulation::{Motions, simulate};
pub use motion::staged_play::{StagedPlay, staged_play};
pub use page::{PageRequest, page};
pub use replay::{Replay, replay};
pub use request::*;
pub use robot::lint::{Finding as LintFinding, Mistake, Repair, RepairedBody, Severity};
pub use write_back::{WrittenBack, own_mjcf, write_mjcf, write_repaired, write_urdf};

// Types of other packages that are inputs or results of the steps.
pub use ::experiments::excitation::artefact::certificate_text;
pub use ::experiments::excitation::certificate_text::parameters_text;
pub use ::experiments::excitation::criterion::SearchObjective;
pub use ::experiments::excitation::enforced_limits::{EnforcedLimit, origins_text};
pub use ::experiments::excitation::error_margins::{ErrorMargins, JointMargin};
pub use ::experiments::excitation::gap_proof::{Gap, Surroundings};
pub use ::experiments::excitation::limits::{CoordinateLimits, LimitsFile};
pub use ::experiments::excitation::margins::Margins;
pub use ::experiments::excitation::motion_claims::{LowestPoint, MotionClaims};
pub use ::experiments::excitation::proof::CertificateRow;
pub use ::experiments::excitation::stopping::{StopBodies, Stopping, StoppingMargin, StoppingMotions};
pub use ::experiments::excitation::visibility::VisibleParameter;
pub use ::experiments::motion::point_trajectory::{Interpolation, PointTrajectory};
pub use ::experiments::motion::profile::Profile;
pub use ::experiments::motion::record::Record;
pub use ::experiments::motion::servo_script::servo_script;
pub use ::experiments::motion::trajectory_file::{TrajectoryFormat, trajectory_file};
pub use ::experiments::plan::exchange::Criterion;
pub use ::experiments::plan::exciting_trajectory::ExcitingTrajectory;
pub use claims::{LeftOut, significant};
pub use codegen::Monitor;
pub use expr::{Count, Function};
pub use gate;
pub use identification::estimate::artefact::Estimate;
pub use identification::estimate::claims::hypotheses::{Hypothesis, HypothesisTest};
pub use identification::estimate::claims::unknowns::UnknownStep;
pub use identification::estimate::delay::Delay as FoundDelay;
pub use identification::estimate::identified::{Identified, Status};
pub use identification::estimate::joint_terms::JointTerms;
pub use identification::estimate::log_check::finding::Finding;
pub use identification::estimate::log_check::visited::VisitedStates;
pub use identification::estimate::logs_left_out::LogLeftOut;
pub use identification::estimate::options::Options;
pub use identification::estimate::residuals::Residuals;
pub use identification::estimate::selection::FrictionSelection;
pub use identification::estimate::torque_error::TorqueError;
pub use identification::estimate::verdict::BodiesEvidence;
pub use identification::estimators::drive_gains::likelihood::Gain;
pub use identification::estimators::weighted::Weights;
pub use linear_model::artefact::ArtefactKind;
pub use linear_model::description_options::{DescriptionOptions, RotorInertias};
pub use linear_model::friction::terms::FrictionTerm;
pub use linear_model::known_load::KnownLoad;
pub use linear_model::parameter::{BaseParameter, Parameter, ParameterId};
pub use linear_model::pseudo_inertia::{Centroidal, Ten};
pub use linear_model::reference::ModelReference;
pub use linear_model::regressor::Regressor;
pub use linear_model::standard_map::StandardMap;
pub use logs::{
    Array, ColumnNames, Columns, Effort, Error as LogError, LogSource, Postures, Proposal, Proposed, Table,
    format_names,
};
pub use modeling::{BaseParameters, Closure, RobotFunction, Rules};
pub use robot::convention::Convention;
pub use robot::format::{AngleSnapping, Mimic, READ_EXTENSIONS, read_text, text_of};
pub use robot::{Inertial, LinkId, Place, Pose, Robot};
