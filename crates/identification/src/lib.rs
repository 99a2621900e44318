//! From experiments to parameters.

mod butterworth;
mod candidates;
mod certificate;
mod closed_loop;
mod columns;
mod compiled;
mod compression;
#[cfg(test)]
mod coverage;
mod cross_talk;
mod cutoff;
mod dataset;
mod dynamics;
mod error;
mod essential;
mod estimate;
mod exciting_trajectory;
mod friction;
mod friction_law;
mod header;
mod huber;
mod identify;
mod identify_consistent;
mod information_matrix;
mod joint_equations;
mod joint_state;
mod known_load;
mod least_squares;
mod log;
mod log_drive_gains;
mod log_report;
mod log_stream;
mod mcap;
mod npz;
mod observation;
mod parquet;
mod parquet_pages;
mod payload;
mod physical;
mod planning;
mod plausible;
mod pseudo_inertia;
mod random;
mod records;
mod regressor;
mod remark;
mod resample;
mod robust;
mod rosbag;
mod selection;
mod signal;
mod simulation;
pub mod spectrum;
mod spectrum_rows;
mod standstill;
mod suspect;
mod table;
mod table_reader;
#[cfg(test)]
mod test_arm;
mod thrift;
mod total_least_squares;
mod transmission;
mod triangle;
mod validation;
mod write_back;

pub use butterworth::Butterworth;
pub use candidates::{Candidate, CandidateGrid, MotionLimits, candidates, swing};
pub use certificate::{ApproximateDesign, ConditionBound, certified_efficiency, condition_bound, determinant_bound};
pub use closed_loop::{ClosedLoop, Simulated, Simulator, simulated};
pub use columns::{ColumnNames, Columns, Names, Source};
pub use compiled::{Compiled, compiled};
pub use cross_talk::{CrossTalk, cross_talk};
pub use cutoff::{FrequencyContent, rule as cutoff_rule};
pub use dataset::{Dataset, LogFile, Run, Score, Subject};
pub use dynamics::{Dynamics, RegressorDynamics, torque};
pub use error::Error;
pub use essential::{Elimination, Essential, essential, select};
pub use estimate::{Estimate, Identified, JointResidual, Status};
pub use exciting_trajectory::{ExcitingTrajectory, Motion, MotionKind, Projector, Reference, SpectralEquation};
pub use friction::{FrictionTerm, label as coordinate_label};
pub use friction_law::FrictionLaw;
pub use header::Quantity;
pub use huber::{Reweighted, reweighted};
pub use identify::{Fit, Options, Weights, identify, identify_all, states};
pub use identify_consistent::{Consistency, ConsistentFit, bodies, identify_consistent, identity_map};
pub use information_matrix::{InformationFactor, InformationMatrix, Rows};
pub use joint_equations::{JointEquations, Scatter};
pub use known_load::{Inertia as LoadInertia, KnownLoad};
pub use least_squares::{Solution, solve};
pub use log::{Effort, Log};
pub use log_drive_gains::estimate_drive_gains;
pub use log_report::LogReport;
pub use log_stream::{LogSource, LogStream};
pub use observation::{Model, Observation, Parameter, RowWeight, weighted};
pub use payload::{Payload, payload};
pub use physical::{Consistent, Outcome, Prior, StandardMap, consistent};
pub use planning::{Criterion, Search, Selection, exchange, value_of};
pub use pseudo_inertia::{
    Centroidal, Ten, centroidal, parameters as ten_parameters, pseudo_inertia, smallest_eigenvalue,
};
pub use random::Random;
pub use records::{Records, SourceRecords};
pub use regressor::Regressor;
pub use resample::{interpolate, uniform_clock};
pub use robust::{Robust, robust};
pub use selection::{
    Delay, FrictionCandidate, FrictionSelection, estimate_delay, friction_candidates, select_friction,
};
pub use signal::{JointSignals, Signal, States, Velocity, Window, gradient};
pub use simulation::{Controller, Drives, Record, Sensing, Simulation, Stop};
pub use spectrum_rows::{EquationBlock, MeasuredMotion, gravity_rows, spectral_rows};
pub use suspect::Suspect;
pub use table::Table;
pub use total_least_squares::{TotalLeastSquares, total_least_squares};
pub use transmission::{Coupling, Transmission};
pub use triangle::{Block, Triangle};
pub use validation::{Validation, cross_validate, residuals, validate};
pub use write_back::{JointDynamics, WrittenBack, mjcf_joints, write_back};

// Identification by spectrum analysis, continued.
mod drive_gains;
mod experiment_plan;
mod filtered_estimation;
mod friction_columns;
mod gain_monte_carlo;
mod gain_total_least_squares;
mod harmonic_estimation;
mod harmonic_fit;
mod harmonic_gains;
mod harmonic_rows;
mod monte_carlo;
mod paper_estimation;
mod profile;
mod record_file;
mod report;
mod scenario;
mod simulation_setup;
mod spectral_experiment;
mod spectral_identification;
mod spectral_validation;
pub mod svg;
mod trajectory_file;
mod validation_trajectory;

pub use drive_gains::{DriveGains, Gain, drive_gains};
pub use experiment_plan::{
    ExperimentPlan, ModelReference, PlannedExperiment, PlannedSweep, PlannedSwing, PredictedParameter,
};
pub use friction_columns::FrictionShape;
pub use gain_monte_carlo::GainComparison;
pub use gain_total_least_squares::{Scaling, gains_by_total_least_squares};
pub use harmonic_estimation::{HarmonicData, HarmonicEstimate, HarmonicOptions};
pub use harmonic_gains::HarmonicGains;
pub use harmonic_rows::{Band, JointSpectrum, joint_spectra};
pub use monte_carlo::{Comparison, Figures, Fixture, Method, inverse_dynamics};
pub use paper_estimation::{PaperWeights, paper_estimate, paper_rows};
pub use profile::Profile;
pub use report::{parameter_picture, report, torque_picture};
pub use scenario::{BenchmarkArm, Scenario};
pub use simulation_setup::{SimulationSetup, motion_limits};
pub use spectral_experiment::{NoiseLevels, SpectralExperiment};
pub use spectral_identification::{SpectralMethod, identify_spectrum};
pub use spectral_validation::{JointValidation, MotionValidation, TorquePicture, ValidationReport, validate_motions};
pub use trajectory_file::{TrajectoryFormat, trajectory_file};
pub use validation_trajectory::{ValidationMotion, validation_trajectory};

#[cfg(test)]
extern crate self as identification;
#[cfg(test)]
#[path = "../tests/tree_robot/candidates.rs"]
mod robot_candidates;
#[cfg(test)]
#[path = "../tests/tally/mod.rs"]
mod tally;
#[cfg(test)]
#[path = "../tests/tree_robot/mod.rs"]
mod tree_robot;
