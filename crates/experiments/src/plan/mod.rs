//! Plans of experiments of one or two joints for identification by spectrum analysis: candidates, choice, and proof of
//! optimality.

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
pub mod plan_proof;
pub mod planned_experiment;
pub mod proof_check;
pub mod proof_search;
pub mod quadratic_model;
pub mod ranges;
pub mod relaxed_design;

#[cfg(test)]
use {
    crate::motion::profile::Profile, candidates::CandidateGrid, candidates::MotionLimits,
    numerics::information_matrix::WeightedRows, random::Random,
};
#[cfg(test)]
mod test_plans;
