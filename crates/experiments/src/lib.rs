//! Designs and simulates motions for identification: exciting motions, plans of experiments, and proofs that motions keep their
//! limits.
//!
//! [`motion`] holds commanded motions and recorded motions. Two modules make informative motions. [`plan`] chooses short
//! experiments of one or two joints for identification by spectrum analysis, and proves that no other choice is much better.
//! [`excitation`] searches one motion of all joints, and proves that it keeps its limits. [`simulate`] runs both on a robot
//! with drives, friction and sensors.
//!
//! This crate depends on the linear model, the numerics, robot models and logs.
//!
//! Not here: the estimation of parameters from a record (`identification`); the equations of a robot, its bodies and its
//! surroundings. The package `rist` passes them to this crate through traits ([`linear_model::differentiable`],
//! [`excitation::gap_proof::Surroundings`], [`excitation::proof::EnclosedTorque`]).

#![warn(missing_docs)]

pub mod excitation;
pub mod motion;
#[cfg(test)]
mod pendulum;
pub mod plan;
pub mod simulate;
