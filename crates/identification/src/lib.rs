//! From experiments to parameters.

mod candidates;
mod certificate;
mod dynamics;
mod exciting_trajectory;
mod friction_law;
mod information_matrix;
mod planning;
mod random;
mod regressor;
mod simulation;
pub mod spectrum;
mod spectrum_rows;

pub use candidates::{Candidate, CandidateGrid, MotionLimits, candidates, swing};
pub use certificate::{ApproximateDesign, ConditionBound, certified_efficiency, condition_bound, determinant_bound};
pub use dynamics::{Dynamics, RegressorDynamics, torque};
pub use exciting_trajectory::{
    ExcitingTrajectory, Motion, MotionKind, Profile, Projector, Reference, SpectralEquation,
};
pub use friction_law::FrictionLaw;
pub use information_matrix::{InformationFactor, InformationMatrix, Rows};
pub use planning::{Criterion, Search, Selection, exchange, value_of};
pub use random::Random;
pub use regressor::Regressor;
pub use simulation::{Controller, Drives, Record, Sensing, Simulation, Stop};
pub use spectrum_rows::{EquationBlock, MeasuredMotion, gravity_rows, spectral_rows};

#[cfg(test)]
extern crate self as identification;
#[cfg(test)]
#[path = "../tests/tree_robot/mod.rs"]
mod tree_robot;
