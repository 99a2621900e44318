//! Motions of a robot: as commanded to the controller, as stored in files, and as recorded.

pub mod point_to_point;
pub mod point_trajectory;
pub mod profile;
pub mod record;
pub mod reference_motion;
pub mod sample_count;
pub mod servo_script;
pub mod trajectory_file;
