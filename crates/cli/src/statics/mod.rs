//! Commands of the wing (optional package) `statics`: postures and wrench.
//!
//! `rist postures` identifies gravity parameters, zeros and the mount of the base from a robot at rest; `rist wrench`
//! identifies a load from the log of a force-torque sensor.

pub(crate) mod postures;
pub(crate) mod wrench;
