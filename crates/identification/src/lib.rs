//! From experiments to parameters.

mod butterworth;
mod columns;
mod cutoff;
mod dataset;
mod error;
mod estimate;
mod friction;
mod header;
mod identify;
mod identify_consistent;
mod least_squares;
mod log;
mod observation;
mod physical;
mod pseudo_inertia;
mod random;
mod regressor;
mod remark;
mod resample;
mod robust;
mod signal;
mod table;
#[cfg(test)]
mod test_arm;
mod transmission;
mod triangle;
mod validation;

pub use butterworth::Butterworth;
pub use columns::{ColumnNames, Columns, Names, Source};
pub use cutoff::{FrequencyContent, rule as cutoff_rule};
pub use dataset::{Dataset, LogFile, Run, Score, Subject};
pub use error::Error;
pub use estimate::{Estimate, Identified, JointResidual, Status};
pub use friction::FrictionTerm;
pub use header::Quantity;
pub use identify::{Fit, Options, Weights, identify, identify_all, states};
pub use identify_consistent::{Consistency, ConsistentFit, bodies, identify_consistent, identity_map};
pub use least_squares::{Solution, solve};
pub use log::{Effort, Log, LogReport};
pub use observation::{Model, Observation, Parameter, weighted};
pub use physical::{Consistent, Outcome, Prior, StandardMap, consistent};
pub use pseudo_inertia::{
    Centroidal, Ten, centroidal, parameters as ten_parameters, pseudo_inertia, smallest_eigenvalue,
};
pub use random::Random;
pub use regressor::Regressor;
pub use resample::{interpolate, uniform_clock};
pub use robust::{Robust, robust};
pub use signal::{JointSignals, Signal, States, Velocity, Window, gradient};
pub use table::Table;
pub use transmission::{Coupling, Transmission};
pub use triangle::{Block, Triangle};
pub use validation::{Validation, cross_validate, residuals, validate};
