//! The kinematics of a robot: its numbers as expressions, the motion of every link, closed loops.
//!
//! Each module uses the modules before it: [`vector`], [`angular_motion`], [`placement`], [`angle`], [`constants`], then
//! [`links`], then [`closure`] and [`implicit`] for loops that are solved numerically.

pub(crate) mod angle;
pub(crate) mod angular_motion;
pub(crate) mod axis_intersections;
pub(crate) mod closure;
pub(crate) mod constants;
pub(crate) mod implicit;
pub(crate) mod links;
pub(crate) mod loop_chain;
pub(crate) mod motion;
pub(crate) mod names;
pub(crate) mod placement;
pub(crate) mod polar;
pub(crate) mod vector;
