//! Exciting experiments: trajectories, candidates, the choice among them, and records.

pub mod branch_and_bound;
pub mod candidates;
pub mod certificate;
pub mod exchange;
pub mod excitation;
pub mod exciting_trajectory;
pub mod experiment_plan;
pub mod measured_motion;
pub mod motion_kind;
pub mod paper_rows;
mod plan_node;
pub mod plan_proof;
pub mod planned_experiment;
pub mod point_to_point;
pub mod profile;
pub mod quadratic_model;
pub mod ranges;
pub mod record;
pub mod reference_motion;
pub mod relaxed_design;
pub mod servo_script;
pub mod trajectory_file;
