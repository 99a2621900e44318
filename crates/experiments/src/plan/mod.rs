//! Experiments of one or two joints for spectrum analysis: candidates, the choice among them, and its proof.

pub mod branch_and_bound;
pub mod candidates;
pub mod certificate;
pub mod exchange;
pub mod exciting_trajectory;
pub mod experiment_plan;
pub mod measured_motion;
pub mod motion_count;
pub mod motion_kind;
pub mod paper_rows;
pub mod permission;
mod plan_node;
pub mod plan_proof;
pub mod planned_experiment;
pub mod proof_again;
pub mod quadratic_model;
pub mod ranges;
pub mod relaxed_design;
