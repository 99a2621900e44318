//! Motions, plans, their proofs, and simulation: what a robot is asked to do, before anything is estimated.
//!
//! [`motion`] has motions as they are asked for and as they were recorded. Two ways lead to one that tells much:
//! [`plan`] chooses short experiments of one or two joints for identification by spectrum analysis, and proves that no
//! other choice is much better; [`excitation`] searches one motion of all joints, and proves its limits. [`simulate`]
//! runs either on a robot with drives, friction and sensors.
//!
//! It knows the linear model, the numbers, what a robot is and what a log is.
//!
//! Not here: how a record becomes parameters (`identification`); what the search needs of a robot's expressions, bodies
//! and surroundings, which `rist` hands over through traits ([`linear_model::differentiable`],
//! [`excitation::gap_proof::Surroundings`], [`excitation::proof::EnclosedTorque`]).

#![warn(missing_docs)]

pub mod excitation;
pub mod motion;
#[cfg(test)]
mod pendulum;
pub mod plan;
pub mod simulate;
