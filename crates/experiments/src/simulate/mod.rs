//! Simulates experiments: a robot with drives, controllers, friction and sensors follows a reference motion. The result is the
//! record of positions and currents (or torques) that an experiment would give.

pub mod closed_loop;
pub mod defaults;
pub mod dynamics;
pub mod record_file;
mod run;
pub mod setup;
mod stiff_friction;
