//! Simulates experiments: a robot with drives, controllers, friction and sensors.

pub mod closed_loop;
pub mod defaults;
pub mod dynamics;
pub mod record_file;
mod run;
pub mod setup;
mod stiff_friction;
