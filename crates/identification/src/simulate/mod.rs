//! Experiments on a simulated robot.

pub mod closed_loop;
pub mod dynamics;
pub mod encoder_torque;
pub mod record_file;
pub mod setup;
