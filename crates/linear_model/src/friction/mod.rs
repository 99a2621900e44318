//! Joint friction, linear in its parameters.
//!
//! The same friction law has three forms: [`terms`] computes its columns at the samples of a log, [`periodic`] its columns over
//! a periodic motion, and [`law`] its torque in a simulated joint.
//! [Vandanjon, Gautier, Desbats 1995, equation (5)]

pub mod law;
pub mod periodic;
pub mod terms;
