//! Estimates that a robot updates in every control cycle: external torque, contact, load, drift of friction.
//!
//! The functions of the robot itself, such as the momentum, are generated (`rist generate`). This crate takes their outputs:
//!
//! ```text
//! momentum p, b = C^T dq - g        function momentum_and_rate of a generated file
//! known torque = tau - friction + b
//! Observer            p, known torque                    -> external torque r
//! Band                speed, regressor row               -> standard deviation of r without contact
//! ContactDetector     r / standard deviation, threshold  -> contact, and the joint before the touched link
//! Payload             r, filtered load_momentum          -> ten parameters of a load, their sigma, which are not determined yet
//! Drift               r, speed                           -> change of viscous friction, Coulomb friction and offset
//! ```
//! No memory is allocated and nothing panics, so the crate is for `no_std` control loops. The numbers are f64 or f32. Units are SI: N m for torques of revolute joints, N for prismatic joints.

#![no_std]
#![forbid(unsafe_code)]
#![warn(missing_docs)]

mod band;
mod contact;
mod drift;
mod load_monitor;
mod observer;
mod payload;
mod real;
mod recursion;

pub use band::{Band, NoiseScale};
pub use contact::{Contact, ContactDetector};
pub use drift::Drift;
pub use load_monitor::{LoadDecision, LoadMonitor};
pub use observer::{Observer, Order};
pub use payload::{Load, Payload, possible};
pub use real::Real;
pub use recursion::Recursion;
