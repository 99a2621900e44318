//! The options (request) of `rist plan`, which chooses experiments for an identification.

use experiments::excitation::limits::LimitsFile;
use experiments::motion::profile::Profile;
use experiments::plan::exchange::Criterion;

use super::Range;

request! {
    /// Options for planning experiments.
    pub struct PlanRequest {
        /// Number of experiments.
        experiments: usize = 8, range(1..=1000), short('n');
        /// What the choice of the experiments optimises.
        criterion: Criterion = Criterion::Determinant;
        /// Profile of the acceleration within a swing, which is a motion between two positions and back.
        profile: Profile = Profile::BangBang;
        /// Number of grid positions of each coordinate.
        steps: usize = 5, range(1..=1000);
        /// Maximum number of configurations for each kind of motion.
        configurations: usize = 60, range(1..=100_000);
        /// YAML with tighter limits of joints and bodies, as for [limits] of `rist excite`.
        limits: Option<LimitsFile> = None, value_name("FILE");
        /// Share of the limits of effort that the torque computed from the description may use.
        effort_share: f64 = 0.9, range(Range::Share), value_name("SHARE");
        /// Recorded time of one experiment, s.
        duration: f64 = 4.0, range(0.1..=3600.0);
        /// Sample rate of the controller, Hz.
        rate: f64 = 1000.0, range(1.0..=2e4);
        /// Number of starts of the search.
        starts: usize = 12, range(1..=10_000);
        /// Seed of the random starts; the same seed gives the same plan.
        seed: u64 = 1;
        /// Maximum number of nodes of a branch-and-bound search; 0: no such search. The search improves the plan, and proves
        /// how far the plan can be from the best plan. It ends when the D-efficiency is within 0.001 of the best. The proof is
        /// written into the plan.
        nodes: usize = 0, range(0..=1_000_000);
    }
}
