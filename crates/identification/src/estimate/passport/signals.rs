//! What the signals of a log say without any inertials: dead and saturated torques, a log too short, angles in degrees,
//! velocities that are not the slopes of their positions, and friction that drives.

use logs::Suspect;

use crate::estimate::hypothesis::Hypothesis;
use crate::estimate::passport::diagnosis::Look;
use crate::estimate::passport::finding::{Fault, Finding, OTHER_TORQUE_SIGN};
use crate::estimate::passport::friction::OwnFriction;
use crate::estimate::passport::report::{JointPassport, Passport};
use crate::estimate::remarks::LARGEST_ARM_ANGLE_RAD;

/// A joint that moves less than this says nothing, rad (m).
const SMALLEST_TELLING_RANGE: f64 = 0.02;

/// Periods without which a log is too short. There and back once is the least that tells inertia from gravity and
/// friction, but a measured motion of one period (cobot6) lacks its ends.
const MIN_PERIODS: f64 = 0.75;

/// Squared correlation above which a velocity is the slope of a position. Measured velocities reach 0.97 and more with
/// their own positions.
const SLOPE_CORRELATION: f64 = 0.8;
/// Squared correlation up to which a velocity is not the slope of a position.
const NO_SLOPE_CORRELATION: f64 = 0.5;

/// No machine gives a torque this small, N m (N): a motor of a watch gives 1e-6.
const SMALLEST_TORQUE: f64 = 1e-30;

/// Share of the rows at a limit above which a torque is saturated. Quantised currents reach 1 % by chance.
const SATURATED_ROWS_SHARE: f64 = 0.05;

impl Look<'_> {
    /// Torques that never change, torques that are nothing, and torques that stand at a limit.
    pub(super) fn dead_and_saturated(&self) -> Vec<Finding> {
        let mut found = Vec::new();
        let dead: Vec<&Suspect> = self.suspects.iter().filter(|s| s.constant.is_some()).collect();
        if !dead.is_empty() {
            let value = |s: &&Suspect| format!("{} in every row", s.constant.unwrap_or(0.0));
            found.push(Finding {
                fault: Fault::DeadTorque,
                joints: dead.iter().map(|s| s.coordinate.clone()).collect(),
                evidence: dead.first().map(value).unwrap_or_default(),
                remedy: "log the measured torques or currents, or name their columns ([options.columns.torque])".into(),
            });
        }
        let (n, tau) = (self.n(), &self.samples.kept.tau);
        let largest = |k: usize| tau.iter().skip(k).step_by(n).fold(0.0, |m: f64, x| m.max(x.abs()));
        let is_told = |k: &usize| {
            let is_it = |s: &Suspect| s.coordinate == self.name(*k);
            self.suspects.iter().any(|s| is_it(s) && (s.constant.is_some() || s.undriven.is_some()))
        };
        let nothing: Vec<usize> = (0..n).filter(|k| largest(*k) < SMALLEST_TORQUE && !is_told(k)).collect();
        if !tau.is_empty() && !nothing.is_empty() {
            found.push(Finding {
                fault: Fault::Nothing(nothing.iter().map(|&k| largest(k)).fold(0.0, f64::max)),
                evidence: "memory that a driver never wrote looks so".into(),
                joints: nothing.into_iter().map(|k| self.name(k)).collect(),
                remedy: "log the measured torques or currents, or name their columns ([options.columns.torque])".into(),
            });
        }
        for suspect in self.suspects {
            let Some(share) = suspect.saturated.filter(|share| *share > SATURATED_ROWS_SHARE) else { continue };
            found.push(Finding {
                fault: Fault::Saturated(share),
                joints: vec![suspect.coordinate.clone()],
                evidence: "its largest and smallest values come again and again".into(),
                remedy: "move more slowly or with less load, or leave that part out (signal: window)".into(),
            });
        }
        found
    }

    /// A log in which nothing comes back.
    pub(super) fn short(&self) -> Option<Finding> {
        let moving = (0..self.n()).filter(|&k| self.range(k) > SMALLEST_TELLING_RANGE);
        let periods = moving.map(|k| self.samples.periods(k)).fold(0.0, f64::max);
        let remedy = "log a motion of at least ten seconds in which each joint moves there and back several times \
                      (rist plan makes one)";
        let evidence = format!("{periods:.2} times there and back at most");
        (periods < MIN_PERIODS).then(|| Finding::of_all(Fault::Short(periods), evidence, remedy))
    }

    /// Angles that no arm reaches.
    pub(super) fn degrees(&self) -> Option<Finding> {
        let far = |k: &usize| {
            let (low, high) = self.samples.range[*k];
            !self.regressor.is_prismatic(*k) && low.abs().max(high.abs()) > LARGEST_ARM_ANGLE_RAD
        };
        let joints: Vec<usize> = (0..self.n()).filter(far).collect();
        let farthest = joints.iter().map(|&k| self.samples.range[k].1.abs().max(self.samples.range[k].0.abs()));
        let farthest = farthest.fold(0.0, f64::max);
        (!joints.is_empty()).then(|| Finding {
            fault: Fault::Of(Hypothesis::Degrees, 0.0),
            evidence: format!("positions reach {farthest:.1} rad, more than two turns"),
            remedy: format!("say the unit in the header ({}_deg)", self.name(joints[0])),
            joints: joints.into_iter().map(|k| self.name(k)).collect(),
        })
    }

    /// Joints whose velocity is not the slope of their position, with the joint of whose position it is the slope.
    pub(super) fn velocities(&self) -> Vec<(usize, Option<usize>, Finding)> {
        let mut found = Vec::new();
        for k in (0..self.n()).filter(|&k| self.range(k) > SMALLEST_TELLING_RANGE && self.samples.velocity[k] > 0.0) {
            let own = self.samples.alike(k, k);
            if own > NO_SLOPE_CORRELATION {
                continue;
            }
            let other = (0..self.n()).filter(|&l| l != k).map(|l| (l, self.samples.alike(k, l)));
            let other = other.filter(|(_, alike)| *alike > SLOPE_CORRELATION).max_by(|a, b| a.1.total_cmp(&b.1));
            let (evidence, remedy) = match other {
                Some((l, alike)) => (
                    format!(
                        "it agrees with the slope of its own position to {own:.2}, with that of {} to {alike:.2}",
                        self.name(l)
                    ),
                    "exchange the columns ([options.columns]: velocity, position)".into(),
                ),
                None => (
                    format!("it agrees with the slope of its position to {own:.2} only"),
                    "name the columns ([options.columns]), or use positions alone (signal: velocity: differentiated)"
                        .into(),
                ),
            };
            let finding = Finding { fault: Fault::Velocity, joints: vec![self.name(k)], evidence, remedy };
            found.push((k, other.map(|o| o.0), finding));
        }
        found
    }

    /// Friction that drives, in joints of which nothing else is known.
    pub(super) fn friction(&self, passport: &Passport, known: &[Finding]) -> Vec<Finding> {
        let accused = |name: &String| known.iter().any(|f| f.joints.contains(name));
        let judged: Vec<_> = passport.joints.iter().filter_map(|j| Some((j, j.friction?))).collect();
        let drives: Vec<_> = judged
            .iter()
            .filter(|(j, f)| f.drives && !accused(&j.coordinate) && j.range > SMALLEST_TELLING_RANGE)
            .collect();
        let evidence = |brakes: f64| format!("friction is {:.0} % of its torque, and negative", -100.0 * brakes);
        if drives.len() >= 2 && 3 * drives.len() >= 2 * judged.len() {
            let mean = drives.iter().map(|d| d.1.brakes).sum::<f64>() / drives.len() as f64;
            let evidence = format!("friction drives {} of {} joints: {}", drives.len(), judged.len(), evidence(mean));
            return vec![Finding::of_all(Fault::TorqueSigns, evidence, OTHER_TORQUE_SIGN)];
        }
        let finding = |(j, friction): &&(&JointPassport, OwnFriction)| Finding {
            fault: Fault::FrictionSign,
            joints: vec![j.coordinate.clone()],
            evidence: evidence(friction.brakes),
            remedy: "change the sign of that column, or, where motor and joint turn in opposite ways, give a negative \
                     ratio ([options.transmission.ratios])"
                .into(),
        };
        drives.iter().map(finding).collect()
    }
}
