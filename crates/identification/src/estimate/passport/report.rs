//! The passport itself: how each joint's torque agrees with the description, the findings, and what is untold.

use std::fmt;

use crate::estimate::digits::significant;
use crate::estimate::passport::finding::{COMMON_FACTORS, Fault, Finding, NOMINAL_INERTIAL_SLOPES};
use crate::estimate::passport::friction::OwnFriction;
use crate::estimate::passport::power::Turned;
use crate::estimate::passport::regression::COUNTED_SLOPE_SHARE;
use crate::estimate::passport::visited::Visited;

/// How a joint's torque agrees with the description.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct JointPassport {
    /// Name of the coordinate.
    pub coordinate: String,
    /// Measured torque per torque of the description, beside rotor, friction and offset; `None` without inertials, or
    /// where the joint has too few samples.
    pub slope: Option<f64>,
    /// Share of the torque's variance that the description explains beyond rotor, friction and offset, on which the
    /// slope rests.
    pub share: Option<f64>,
    /// Share of the torque's variance that the description explains with rotor, friction and offset.
    pub explained: Option<f64>,
    /// Friction by the joint's own row of the regressor; `None` where it cannot be told.
    pub friction: Option<OwnFriction>,
    /// Distance between the ends of its motion, rad (m).
    pub range: f64,
    /// Time by which its velocity lags the slope of its position, s; `None` where it hardly moves.
    pub velocity_lag: Option<f64>,
    /// Deviation of that time, s.
    pub velocity_lag_deviation: f64,
    /// Correlation of its acceleration with the slope of its velocity, and its size beside it; `None` where one of them is
    /// zero.
    pub acceleration: Option<(f64, f64)>,
    /// Whether its acceleration is not the slope of its velocity.
    pub wrong_acceleration: bool,
    /// The least offset of its zero that would have been found, rad; `None` where none would.
    pub zero_power: Option<f64>,
}

/// Which columns the velocities and accelerations come from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Measured {
    /// The velocities, from columns of the log.
    pub velocity: bool,
    /// The accelerations, from columns of the log.
    pub acceleration: bool,
}

/// A mistake that a log does not need: other bodies than the description's explain it as well.
#[derive(Clone, Debug, PartialEq)]
pub struct Explained {
    /// The mistake.
    pub finding: Finding,
    /// Whether the description asks for it: with it undone it predicts the log better by far.
    pub is_likely: bool,
}

/// What a log says of itself and of its description before anything is fitted.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Passport {
    /// One per coordinate.
    pub joints: Vec<JointPassport>,
    /// The worst first.
    pub findings: Vec<Finding>,
    /// Other explanations of the log than the findings; none once they are tried.
    pub others: Vec<Vec<Finding>>,
    /// What was found with the bodies of the description, and other bodies explain as well.
    pub explained: Vec<Explained>,
    /// A load that the description does not have: no fault of a log, and part of the parameters.
    pub load: Option<Finding>,
    /// What could not be looked at, in sentences.
    pub untold: Vec<String>,
    /// Whether the motion is so short that only what explains nearly all of it is said.
    pub is_short: bool,
    /// Where the robot was.
    pub visited: Visited,
    /// Which columns were used.
    pub measured: Measured,
    /// The joint that the description would rather have elsewhere.
    pub turned: Option<Turned>,
    /// Pairs of joints, or of limbs, whose columns might be exchanged: the description would not show it.
    pub hidden_exchanges: Vec<[Vec<usize>; 2]>,
    /// Whether the columns belong to joints by their place, and not by their names.
    pub is_by_place: bool,
}

/// Share below which a slope is not shown.
const SHOWN_SLOPE_SHARE: f64 = 0.05;

impl JointPassport {
    /// Whether its friction drives, and its torque is that of the description with the other sign.
    pub(super) fn runs_back(&self) -> bool {
        let is_negative = self.slope.is_some_and(|slope| slope < 0.0);
        let is_told = self.share.is_some_and(|share| share > COUNTED_SLOPE_SHARE);
        is_negative && is_told && self.friction.is_some_and(|f| f.drives)
    }

    /// The size of its slope, where that counts, and the gain that the description implies beside `gain`: `q1=11.5`.
    fn implied_gain(&self, gain: f64) -> Option<(f64, String)> {
        let slope = self.slope.filter(|_| self.share.is_some_and(|share| share > COUNTED_SLOPE_SHARE))?.abs();
        Some((slope, format!("{}={}", self.coordinate, significant(gain / slope))))
    }
}

fn by_description(gains: &[String]) -> String {
    format!("by the description about [gain={}], as far as its masses are right", gains.join(","))
}

impl Passport {
    /// The same with what another look at the same log says of its columns.
    pub fn with_columns_of(mut self, other: Passport) -> Passport {
        self.measured = other.measured;
        // A velocity that is no late slope is that of another joint, or of nothing.
        let is_late = |name: &String| other.joints.iter().any(|j| j.coordinate == *name && j.velocity_lag.is_some());
        let is_foreign = |f: &&Finding| f.fault == Fault::Velocity && !f.joints.iter().any(is_late);
        let foreign: Vec<Finding> = other.findings.iter().filter(is_foreign).cloned().collect();
        self.findings.extend(foreign.into_iter().filter(|f| !self.findings.contains(f)).collect::<Vec<_>>());
        for (joint, of) in self.joints.iter_mut().zip(other.joints) {
            joint.velocity_lag = of.velocity_lag;
            joint.velocity_lag_deviation = of.velocity_lag_deviation;
            joint.acceleration = of.acceleration;
            joint.wrong_acceleration = of.wrong_acceleration;
        }
        self
    }

    /// Time by which velocities lag the slopes of positions, s: that of the middle joint, because a filter acts on all.
    pub fn velocity_lag(&self) -> Option<f64> {
        let mut lags: Vec<f64> = self.joints.iter().filter_map(|j| j.velocity_lag).collect();
        lags.sort_by(f64::total_cmp);
        lags.get(lags.len() / 2).copied()
    }

    /// Whether there was a description to hold the log against.
    pub(crate) fn has_description(&self) -> bool {
        self.joints.iter().any(|j| j.slope.is_some())
    }

    /// Whether a finding forbids to use an estimate from this log.
    pub fn is_gross(&self) -> bool {
        self.findings.iter().any(|f| f.fault.is_gross())
    }

    /// Compares the drive gains that make torques of the log's currents, one per coordinate, with what the description
    /// implies.
    ///
    /// A torque that is s times the description's comes from a gain that is s times too large.
    pub fn gains_are(&mut self, gains: &[f64]) {
        let all = self.joints.iter().zip(gains);
        let mut found: Vec<(f64, String)> = all.filter_map(|(joint, gain)| joint.implied_gain(*gain)).collect();
        let implied: Vec<String> = found.iter().map(|(_, text)| text.clone()).collect();
        found.sort_by(|a, b| a.0.total_cmp(&b.0));
        let Some(factor) = found.get(found.len() / 2).map(|f| f.0).filter(|_| found.len() >= gains.len().min(2)) else {
            return;
        };
        self.findings.retain(|f| !f.is_of_scale());
        // A load, or bodies that differ, move some joints only.
        let all = |is_off: &dyn Fn(f64) -> bool| found.iter().all(|(slope, _)| is_off(*slope));
        let is_off = all(&|s| s > COMMON_FACTORS.end) || all(&|s| s < COMMON_FACTORS.start);
        let is_off = is_off || !NOMINAL_INERTIAL_SLOPES.contains(&factor);
        if self.findings.is_empty() && is_off {
            let texts: Vec<String> = found.iter().map(|(slope, _)| significant(*slope)).collect();
            let evidence = format!("slopes of the description {}", texts.join(" "));
            self.findings.push(Finding::of_all(Fault::Gains(factor), evidence, by_description(&implied)));
        }
    }

    /// Notes what gains the description implies where the efforts are known to be currents, which is no fault.
    pub fn efforts_are_currents(&mut self) {
        let unit: Vec<Finding> = self.findings.extract_if(.., |f| f.is_of_scale()).collect();
        self.untold.extend(unit.iter().map(|f| format!("currents without gains: {}; {}", f.evidence, f.remedy)));
    }

    /// Notes the same of servos whose position errors were taken for torques, with gains of one; `scale` says what that means.
    pub fn efforts_are_position_errors(&mut self, scale: &str) {
        self.findings.retain(|f| !f.is_of_scale() && !matches!(f.fault, Fault::Gains(_)));
        let implied: Vec<String> = self.joints.iter().filter_map(|j| Some(j.implied_gain(1.0)?.1)).collect();
        let known = match implied.is_empty() {
            true => "a gain that is known is given by [gain]".to_string(),
            false => by_description(&implied),
        };
        self.untold.push(format!("{scale}; {known}"));
    }
}

impl fmt::Display for Passport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let width = self.joints.iter().map(|j| j.coordinate.chars().count()).max().unwrap_or(0).max(5);
        let head = ["slope", "by it", "explained", "friction"];
        writeln!(f, "{:<width$}  {:>8}  {:>6}  {:>9}  {:<9}", "joint", head[0], head[1], head[2], head[3])?;
        let percent = |x: Option<f64>| x.map_or("-".into(), |x| format!("{:.0} %", 100.0 * x));
        for j in &self.joints {
            // A slope that stands on little says little.
            let slope = match (j.slope, j.share) {
                (Some(slope), Some(share)) if share > COUNTED_SLOPE_SHARE => significant(slope),
                (Some(slope), Some(share)) if share > SHOWN_SLOPE_SHARE => format!("({})", significant(slope)),
                _ => "-".into(),
            };
            let friction = match j.friction {
                None => "-",
                Some(friction) if friction.drives => "drives",
                Some(friction) if friction.brakes > 0.0 => "brakes",
                Some(_) => "unclear",
            };
            let (share, explained) = (percent(j.share), percent(j.explained));
            writeln!(f, "{:<width$}  {slope:>8}  {share:>6}  {explained:>9}  {friction}", j.coordinate)?;
        }
        Ok(())
    }
}
