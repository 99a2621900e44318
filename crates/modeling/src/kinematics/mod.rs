//! How the links move: the robot's numbers as expressions, the motion of every link, closed loops.
//!
//! From the bottom up: [`vector`], [`spin`], [`placement`], [`angle`], [`constants`], then [`links`], then [`closure`] and
//! [`implicit`] for the loops that no affine function closes.

pub(crate) mod angle;
pub(crate) mod closure;
pub(crate) mod constants;
pub(crate) mod implicit;
pub(crate) mod links;
pub(crate) mod loop_chain;
pub(crate) mod motion;
pub(crate) mod names;
pub(crate) mod placement;
pub(crate) mod polar;
pub(crate) mod poles;
pub(crate) mod spin;
pub(crate) mod vector;
