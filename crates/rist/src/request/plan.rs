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
        /// What the plan makes best.
        criterion: Criterion = Criterion::Determinant;
        /// Acceleration within a swing.
        profile: Profile = Profile::BangBang;
        /// Configurations of the grid per coordinate.
        steps: usize = 5, range(1..=1000);
        /// Maximum number of configurations per kind of motion.
        configurations: usize = 60, range(1..=100_000);
        /// YAML with tighter limits, and with the room of the bodies, as for `rist excite`.
        limits: Option<LimitsFile> = None, value_name("FILE");
        /// Share of the limits of effort that the torque of the description may use.
        effort_share: f64 = 0.9, range(Range::Share), value_name("SHARE");
        /// Seconds recorded in one experiment.
        duration: f64 = 4.0, range(0.1..=3600.0);
        /// Sample rate of the controller, Hz.
        rate: f64 = 1000.0, range(1.0..=2e4);
        /// Starts of the search.
        starts: usize = 12, range(1..=10_000);
        /// Seed of the random starts; the same seed gives the same plan.
        seed: u64 = 1;
        /// Maximum number of nodes of a branch and bound, 0 for none. It improves the plan and proves how far from the best
        /// it can be. It ends where the D-efficiency is within 0.001 of the best. The proof is written into the plan.
        nodes: usize = 0, range(0..=1_000_000);
    }
}
