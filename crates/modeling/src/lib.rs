//! Derives the equations of a robot: the regressor D(q, dq, ddq), the torques, the base parameters and further functions.
//!
//! tau = D X with X the standard parameters of the links ([`robot::StandardParameter`]); D is
//! derived symbolically as an [`expr::Function`], once, with the robot's lengths and angles as named
//! constants. This package neither reads files nor prints.

#![warn(missing_docs)]
#![allow(non_snake_case, reason = "Khalil's notation, docs/notation.md")]

mod base;
pub mod building;
mod derivation;
mod dynamics;
mod kinematics;
mod robot_formulas;
mod robot_function;
mod robot_module;
mod size;

pub use base::base_parameters::{BaseParameter, BaseParameters, Term, WeakParameter};
pub use base::closed::reason::NoCertificate;
pub use base::evidence::{ExactRank, Rank};
pub use base::exact_geometry::{GeometricError, independent_geometric_errors};
pub use base::meaning::standard_meaning;
pub use base::rank::{Scan, independent_columns};
pub use base::unclear_rank::UnclearRank;
pub use base::written_rules::Rules;
pub use derivation::{Derivation, NeverCloses};
pub use dynamics::link_frame::LinkFrame;
pub use dynamics::reference_frame::ReferenceFrame;
pub use kinematics::closure::{Closure, NotClosed};
pub use robot_formulas::{RobotFormulas, formulas};
pub use robot_function::{FunctionOfLink, NotThere, RobotFunction, register_functions};
pub use robot_module::{ModuleWithSymbols, module, module_with_symbols};
pub use size::Size;
