//! Motions and plans of motions: search, proof, check, simulation and playing.
//!
//! A motion is found and proved by `exciting`, a plan of several motions by `planning`. `checking` and `checking_trajectories`
//! prove limits again, `simulation` simulates, and `play` and `staged_play` write files for a controller.

pub(crate) mod after_estimate;
pub mod checking;
pub(crate) mod checking_trajectories;
pub(crate) mod excite_timing;
pub mod exciting;
pub(crate) mod free_memory;
pub(crate) mod kept_room;
pub(crate) mod known_torque;
pub mod motion_plot_data;
pub(crate) mod no_motion_found;
pub(crate) mod nominal;
pub(crate) mod plan_permission;
pub mod planning;
pub mod play;
pub(crate) mod play_advice;
pub mod played_file;
pub(crate) mod proved_motion;
pub mod simulation;
pub mod staged_play;
