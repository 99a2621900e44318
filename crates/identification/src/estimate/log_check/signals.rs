//! Checks the signals of a log without the inertial parameters of the robot description: dead or saturated torques, a log that
//! is too short, angles in degrees, velocities that are not the derivatives of the positions, and negative friction.

use logs::Suspect;

use crate::estimate::hypothesis::Hypothesis;
use crate::estimate::log_check::change::Change;
use crate::estimate::log_check::diagnosis::DiagnosisInput;
use crate::estimate::log_check::finding::{Fault, Finding, OTHER_TORQUE_SIGN};
use crate::estimate::log_check::friction::JointFriction;
use crate::estimate::log_check::report::{JointCheck, LogCheck};
use crate::estimate::remarks::LARGEST_ARM_ANGLE_RAD;

/// A joint is not examined if its range of motion is below this value, rad (m).
const SMALLEST_EXAMINED_RANGE: f64 = 0.02;

/// Least number of periods (there and back) of a log. One period separates inertia from gravity and friction; the limit is
/// lower because the ends of a logged period may be missing (log of cobot6).
const MIN_PERIODS: f64 = 0.75;

/// A velocity is the derivative of a position if their squared correlation exceeds this value. A measured velocity and the
/// position of the same joint reach at least 0.97.
const DERIVATIVE_CORRELATION: f64 = 0.8;
/// A velocity is not the derivative of a position if their squared correlation is at most this value.
const NO_DERIVATIVE_CORRELATION: f64 = 0.5;

/// Torques below this value cannot be measurements of a machine, N m (N). The margin is wide: the motor of a watch has 1e-6 N
/// m.
const SMALLEST_TORQUE: f64 = 1e-30;

/// Remedy for a log without measured torques.
const NAME_TORQUES: &str = "log the measured torques or currents, or name their columns ([options.columns.torque])";

/// A torque is saturated if it equals its limit in more than this share of the rows. Quantised currents reach 1 % by chance.
const SATURATED_ROWS_SHARE: f64 = 0.05;

impl DiagnosisInput<'_> {
    /// Findings on torques that never change, that are too small for a machine, or that are saturated.
    pub(super) fn dead_and_saturated(&self) -> Vec<Finding> {
        let mut found = Vec::new();
        let dead: Vec<&Suspect> = self.suspects.iter().filter(|s| s.constant.is_some()).collect();
        if !dead.is_empty() {
            let value = |s: &&Suspect| format!("{} in every row", s.constant.unwrap_or(0.0));
            let joints = dead.iter().map(|s| s.coordinate.clone()).collect();
            let evidence = dead.first().map(value).unwrap_or_default();
            found.push(Finding::of(Fault::DeadTorque, joints, evidence, NAME_TORQUES));
        }
        let (n, tau) = (self.n(), &self.samples.kept.tau);
        // Torques that are not constant may still be far too small for a measurement. Joints are left out if their torque is
        // constant (reported above), or if it is known that they have no measured torque.
        let largest = |k: usize| tau.iter().skip(k).step_by(n).fold(0.0, |m: f64, x| m.max(x.abs()));
        let has_finding = |k: &usize| {
            let is_it = |s: &Suspect| s.coordinate == self.name(*k);
            self.suspects.iter().any(|s| is_it(s) && (s.constant.is_some() || s.undriven.is_some()))
        };
        let nothing: Vec<usize> = (0..n).filter(|k| largest(*k) < SMALLEST_TORQUE && !has_finding(k)).collect();
        if !tau.is_empty() && !nothing.is_empty() {
            let fault = Fault::Nothing(nothing.iter().map(|&k| largest(k)).fold(0.0, f64::max));
            let joints = nothing.into_iter().map(|k| self.name(k)).collect();
            let evidence = "memory that a driver never wrote looks so".into();
            found.push(Finding::of(fault, joints, evidence, NAME_TORQUES));
        }
        // A saturated torque is a separate finding for each joint, because the share of saturated rows differs by joint.
        for suspect in self.suspects {
            let Some(share) = suspect.saturated.filter(|share| *share > SATURATED_ROWS_SHARE) else { continue };
            let evidence = "its largest and smallest values come again and again".into();
            let remedy = "move more slowly or with less load, or leave that part out (signal: window)";
            found.push(Finding::of(Fault::Saturated(share), vec![suspect.coordinate.clone()], evidence, remedy));
        }
        found
    }

    /// The finding that the log is too short; `None` if the log has enough periods.
    pub(super) fn short(&self) -> Option<Finding> {
        let moving = (0..self.n()).filter(|&k| self.range(k) > SMALLEST_EXAMINED_RANGE);
        let periods = moving.map(|k| self.samples.periods(k)).fold(0.0, f64::max);
        let remedy = "log a motion of at least ten seconds in which each joint moves there and back several times \
                      (rist plan makes one)";
        let evidence = format!("{periods:.2} times there and back at most");
        (periods < MIN_PERIODS).then(|| Finding::of_all(Fault::Short(periods), evidence, remedy))
    }

    /// The finding that angles are in degrees, because they exceed the range of any arm in rad; `None` if no angle exceeds this
    /// range.
    pub(super) fn degrees(&self) -> Option<Finding> {
        let far = |k: &usize| {
            let (low, high) = self.samples.range[*k];
            !self.regressor.is_prismatic(*k) && low.abs().max(high.abs()) > LARGEST_ARM_ANGLE_RAD
        };
        let joints: Vec<usize> = (0..self.n()).filter(far).collect();
        let farthest = joints.iter().map(|&k| self.samples.range[k].1.abs().max(self.samples.range[k].0.abs()));
        let farthest = farthest.fold(0.0, f64::max);
        (!joints.is_empty()).then(|| {
            let evidence = format!("positions reach {farthest:.1} rad, more than two turns");
            let remedy = format!("say the unit in the header ({}_deg)", self.name(joints[0]));
            let names = joints.into_iter().map(|k| self.name(k)).collect();
            let undo = vec![Change::of(Hypothesis::Degrees)];
            Finding::of(Fault::Of(Hypothesis::Degrees, 0.0), names, evidence, remedy).undone_by(undo)
        })
    }

    /// The joints whose velocity is not the derivative of their position. For each: its number, the number of the other joint
    /// whose position fits (if any), and the finding.
    pub(super) fn velocities(&self) -> Vec<(usize, Option<usize>, Finding)> {
        let mut found = Vec::new();
        for k in (0..self.n()).filter(|&k| self.range(k) > SMALLEST_EXAMINED_RANGE && self.samples.velocity[k] > 0.0) {
            let own = self.samples.alike(k, k);
            if own > NO_DERIVATIVE_CORRELATION {
                continue;
            }
            let other = (0..self.n()).filter(|&l| l != k).map(|l| (l, self.samples.alike(k, l)));
            let other = other.filter(|(_, alike)| *alike > DERIVATIVE_CORRELATION).max_by(|a, b| a.1.total_cmp(&b.1));
            let (evidence, remedy): (String, &str) = match other {
                Some((l, alike)) => (
                    format!(
                        "it agrees with the slope of its own position to {own:.2}, with that of {} to {alike:.2}",
                        self.name(l)
                    ),
                    "exchange the columns ([options.columns]: velocity, position)",
                ),
                None => (
                    format!("it agrees with the slope of its position to {own:.2} only"),
                    "name the columns ([options.columns]), or use positions alone (signal: velocity: differentiated)",
                ),
            };
            let finding = Finding::of(Fault::Velocity, vec![self.name(k)], evidence, remedy);
            found.push((k, other.map(|o| o.0), finding));
        }
        found
    }

    /// The finding that the torques of all joints have the wrong sign.
    pub(super) fn all_signs(&self, evidence: String) -> Finding {
        let undo = (0..self.n()).map(|k| Change::of(Hypothesis::TorqueSign(k))).collect();
        Finding::of_all(Fault::TorqueSigns, evidence, OTHER_TORQUE_SIGN).undone_by(undo)
    }

    /// Findings of negative friction in joints that have no other finding.
    pub(super) fn friction(&self, log_check: &LogCheck, known: &[Finding]) -> Vec<Finding> {
        let accused = |name: &String| known.iter().any(|f| f.joints.contains(name));
        let judged: Vec<_> = log_check.joints.iter().filter_map(|j| Some((j, j.friction?))).collect();
        let drives: Vec<_> = judged
            .iter()
            .filter(|(j, f)| f.drives && !accused(&j.coordinate) && j.range() > SMALLEST_EXAMINED_RANGE)
            // In a short motion, negative friction alone is weak evidence.
            .filter(|(j, _)| !log_check.is_short || j.slope.is_none() || j.runs_back())
            .collect();
        let evidence = |brakes: f64| format!("friction is {:.0} % of its torque, and negative", -100.0 * brakes);
        if drives.len() >= 2 && 3 * drives.len() >= 2 * judged.len() {
            let mean = drives.iter().map(|d| d.1.brakes).sum::<f64>() / drives.len() as f64;
            let evidence = format!("friction drives {} of {} joints: {}", drives.len(), judged.len(), evidence(mean));
            return vec![self.all_signs(evidence)];
        }
        let remedy = "change the sign of that column, or, where motor and joint turn in opposite ways, give a negative ratio \
                      ([options.transmission.ratios])";
        let finding = |(j, friction): &&(&JointCheck, JointFriction)| {
            let undo = (0..self.n()).filter(|k| self.name(*k) == j.coordinate).map(Hypothesis::TorqueSign);
            let joints = vec![j.coordinate.clone()];
            Finding::of(Fault::FrictionSign, joints, evidence(friction.brakes), remedy)
                .undone_by(undo.map(Change::of).collect())
        };
        drives.iter().map(finding).collect()
    }
}
