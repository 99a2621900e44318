//! Joint friction, linear in its parameters.
//!
//! One law has three faces: [`terms`] holds its columns at the samples of a log, [`periodic`] its columns over a
//! periodic motion, [`law`] the torque that it makes in a simulated joint.
//! [Vandanjon, Gautier, Desbats 1995, equation (5)]

pub mod law;
pub mod periodic;
pub mod terms;
