//! What follows from a robot: the regressor D(q, dq, ddq), the torque, the base parameters.
//!
//! tau = D X with X the standard parameters of the links ([`robot::StandardParameter`]); D is
//! derived symbolically as an [`expr::Function`], once, with the robot's lengths and angles as named
//! constants. Nothing here reads files or prints.

#![allow(non_snake_case, reason = "Khalil's notation, docs/notation.md")]

mod angle;
mod base_parameters;
mod closure;
mod coefficient;
mod composite;
mod constants;
mod derivation;
mod energy;
mod exact_rank;
mod field;
mod forward_dynamics;
mod friction;
mod implicit;
mod inertia_matrix;
mod interpolation;
mod kinematics;
mod names;
mod pose;
mod rank;
mod regressor;
mod rigid_regrouping;
mod robot_module;
mod rule;
mod torque;
mod vector;

pub use base_parameters::{BaseParameter, BaseParameters, Rank, Term, UnclearRank};
pub use closure::{Closure, Open};
pub use derivation::{Derivation, NeverCloses};
pub use robot_module::{RobotFunction, module};
