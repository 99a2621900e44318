//! Joint friction, linear in its parameters.
//!
//! Three forms of one friction law: [`terms`] has its columns at the samples of a log, [`periodic`] its columns over a
//! periodic motion, [`law`] its torque in a simulated joint.
//! [Vandanjon, Gautier, Desbats 1995, equation (5)]

pub mod law;
pub mod periodic;
pub mod terms;
