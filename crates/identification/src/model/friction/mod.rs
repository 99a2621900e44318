//! Joint friction, linear in its parameters.
//!
//! Three faces of one law: [`terms`] the columns at samples of a log, [`periodic`] the columns of a periodic motion
//! (equation (5) of Vandanjon, Gautier and Desbats 1995), [`law`] what the joint of a simulated robot does.

pub mod law;
pub mod periodic;
pub mod terms;
