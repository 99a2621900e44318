//! From experiments to parameters.

mod dynamics;
mod exciting_trajectory;
mod friction_law;
mod random;
mod regressor;
mod simulation;
pub mod spectrum;

pub use dynamics::{Dynamics, RegressorDynamics, torque};
pub use exciting_trajectory::{
    ExcitingTrajectory, Motion, MotionKind, Profile, Projector, Reference, SpectralEquation,
};
pub use friction_law::FrictionLaw;
pub use random::Random;
pub use regressor::Regressor;
pub use simulation::{Controller, Drives, Record, Sensing, Simulation, Stop};

#[cfg(test)]
extern crate self as identification;
#[cfg(test)]
#[path = "../tests/tree_robot/mod.rs"]
mod tree_robot;
