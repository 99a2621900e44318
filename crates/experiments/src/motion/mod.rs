//! One motion: as the controller is asked for it, as files hold it, and as it was recorded.

pub mod point_to_point;
pub mod point_trajectory;
pub mod profile;
pub mod record;
pub mod reference_motion;
pub mod sample_count;
pub mod servo_script;
pub mod trajectory_file;
