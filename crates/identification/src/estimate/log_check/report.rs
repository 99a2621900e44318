//! The result of a log check: agreement of each joint with the description, findings, and undetermined properties.

use std::fmt;

use crate::estimate::digits::significant;
use crate::estimate::log_check::finding::{COMMON_FACTORS, Fault, Finding, NOMINAL_INERTIAL_SLOPES};
use crate::estimate::log_check::friction::JointFriction;
use crate::estimate::log_check::power::MisplacedJoint;
use crate::estimate::log_check::regression::COUNTED_SLOPE_SHARE;
use crate::estimate::log_check::visited::VisitedStates;

/// Agreement of the torque of one joint with the description.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct JointCheck {
    /// Name of the coordinate.
    pub coordinate: String,
    /// Regression slope of the measured torque by the nominal torque, given rotor, friction and offset; `None` without
    /// inertials, or where the joint has too few samples.
    pub slope: Option<f64>,
    /// Share of the squared residual of rotor, friction and offset that the description explains; the weight of the
    /// evidence for the slope.
    pub share: Option<f64>,
    /// Share of the variance of the torque that the description explains together with rotor, friction and offset.
    pub explained: Option<f64>,
    /// Friction by the joint's own row of the regressor; `None` where it cannot be determined.
    pub friction: Option<JointFriction>,
    /// Range of its motion, rad (m).
    pub range: f64,
    /// Lag of its velocity behind the derivative of its position, s; `None` where it hardly moves.
    pub velocity_lag: Option<f64>,
    /// Standard deviation of that lag, s.
    pub velocity_lag_deviation: f64,
    /// Correlation of its acceleration with the derivative of its velocity, and the ratio of their rms values; `None` where
    /// one of them is zero.
    pub acceleration: Option<(f64, f64)>,
    /// Whether its acceleration is not the derivative of its velocity.
    pub wrong_acceleration: bool,
    /// The smallest detectable offset of its zero, rad; `None` where no offset would be detected.
    pub zero_power: Option<f64>,
}

/// Whether velocities and accelerations come from columns of the log.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Measured {
    /// The velocities, from columns of the log.
    pub velocity: bool,
    /// The accelerations, from columns of the log.
    pub acceleration: bool,
}

/// A possible fault that a log does not need, since bodies that differ from the nominal ones explain it equally well.
#[derive(Clone, Debug, PartialEq)]
pub struct ExplainedMistake {
    /// The possible fault.
    pub finding: Finding,
    /// Whether the description predicts the log far better with the fault undone.
    pub is_likely: bool,
}

/// The result of the check of a log against a description, before any fit.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LogCheck {
    /// One per coordinate.
    pub joints: Vec<JointCheck>,
    /// The findings, the worst first.
    pub findings: Vec<Finding>,
    /// Alternative explanations of the log; empty once they are tried.
    pub others: Vec<Vec<Finding>>,
    /// Possible faults by the nominal bodies that other bodies explain equally well.
    pub explained: Vec<ExplainedMistake>,
    /// A load that the description does not have: no fault of a log, but part of the parameters.
    pub load: Option<Finding>,
    /// Properties that could not be determined, in sentences.
    pub not_checked: Vec<String>,
    /// Whether the motion is so short that only faults that explain nearly all of the misfit are reported.
    pub is_short: bool,
    /// States that the robot visited.
    pub visited: VisitedStates,
    /// Whether columns of velocity and acceleration were used.
    pub measured: Measured,
    /// The joint whose offset makes the description fit better.
    pub turned: Option<MisplacedJoint>,
    /// Pairs of joints, or of limbs, whose exchange the description would not detect.
    pub hidden_exchanges: Vec<[Vec<usize>; 2]>,
    /// Whether the columns belong to joints by their place, and not by their names.
    pub is_by_place: bool,
}

/// Share below which a slope is not shown.
const SHOWN_SLOPE_SHARE: f64 = 0.05;

impl JointCheck {
    /// Whether its friction is negative, and its torque follows the nominal torque with the other sign.
    pub(super) fn runs_back(&self) -> bool {
        let is_negative = self.slope.is_some_and(|slope| slope < 0.0);
        let is_meaningful = self.share.is_some_and(|share| share > COUNTED_SLOPE_SHARE);
        is_negative && is_meaningful && self.friction.is_some_and(|f| f.drives)
    }

    /// The magnitude of its slope, where meaningful, and the gain that the description implies instead of `gain`: `q1=11.5`.
    fn implied_gain(&self, gain: f64) -> Option<(f64, String)> {
        let slope = self.slope.filter(|_| self.share.is_some_and(|share| share > COUNTED_SLOPE_SHARE))?.abs();
        Some((slope, format!("{}={}", self.coordinate, significant(gain / slope))))
    }
}

fn by_description(gains: &[String]) -> String {
    format!("by the description about [gain={}], as far as its masses are right", gains.join(","))
}

impl LogCheck {
    /// This log check with the results on columns of another check of the same log.
    pub fn with_columns_of(mut self, other: LogCheck) -> LogCheck {
        self.measured = other.measured;
        // A velocity without a lag is no late derivative: it belongs to another joint, or is no velocity.
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

    /// Lag of velocities behind the derivatives of positions, s: the median over joints, because a filter acts on all.
    pub fn velocity_lag(&self) -> Option<f64> {
        let mut lags: Vec<f64> = self.joints.iter().filter_map(|j| j.velocity_lag).collect();
        lags.sort_by(f64::total_cmp);
        lags.get(lags.len() / 2).copied()
    }

    /// Whether the log was compared with a description.
    pub(crate) fn has_description(&self) -> bool {
        self.joints.iter().any(|j| j.slope.is_some())
    }

    /// Whether a finding makes estimates from this log unusable.
    pub fn is_gross(&self) -> bool {
        self.findings.iter().any(|f| f.fault.is_gross())
    }

    /// Compares the drive gains of the log's currents, one per coordinate, N m/A, with the gains that the description
    /// implies.
    ///
    /// A torque that is s times the nominal torque comes from a gain that is s times too large.
    pub fn gains_are(&mut self, gains: &[f64]) {
        let all = self.joints.iter().zip(gains);
        let mut found: Vec<(f64, String)> = all.filter_map(|(joint, gain)| joint.implied_gain(*gain)).collect();
        let implied: Vec<String> = found.iter().map(|(_, text)| text.clone()).collect();
        found.sort_by(|a, b| a.0.total_cmp(&b.0));
        let Some(factor) = found.get(found.len() / 2).map(|f| f.0).filter(|_| found.len() >= gains.len().min(2)) else {
            return;
        };
        self.findings.retain(|f| !f.is_of_scale());
        // A load, or other bodies, change the slopes of some joints only.
        let all = |is_off: &dyn Fn(f64) -> bool| found.iter().all(|(slope, _)| is_off(*slope));
        let is_off = all(&|s| s > COMMON_FACTORS.end) || all(&|s| s < COMMON_FACTORS.start);
        let is_off = is_off || !NOMINAL_INERTIAL_SLOPES.contains(&factor);
        if self.findings.is_empty() && is_off {
            let texts: Vec<String> = found.iter().map(|(slope, _)| significant(*slope)).collect();
            let evidence = format!("measured over nominal torque, by joint: {}", texts.join(" "));
            self.findings.push(Finding::of_all(Fault::Gains(factor), evidence, by_description(&implied)));
        }
    }

    /// Notes the gains that the description implies where the efforts are known to be currents, which is no fault.
    pub fn efforts_are_currents(&mut self) {
        let unit: Vec<Finding> = self.findings.extract_if(.., |f| f.is_of_scale()).collect();
        self.not_checked.extend(unit.iter().map(|f| format!("currents without gains: {}; {}", f.evidence, f.remedy)));
    }

    /// Notes the implied gains of servos whose position errors were used as torques with gains of 1; `scale`: the meaning of
    /// that scale, as a sentence.
    pub fn efforts_are_position_errors(&mut self, scale: &str) {
        self.findings.retain(|f| !f.is_of_scale() && !matches!(f.fault, Fault::Gains(_)));
        let implied: Vec<String> = self.joints.iter().filter_map(|j| Some(j.implied_gain(1.0)?.1)).collect();
        let known = match implied.is_empty() {
            true => "a gain that is known is given by [gain]".to_string(),
            false => by_description(&implied),
        };
        self.not_checked.push(format!("{scale}; {known}"));
    }
}

impl fmt::Display for LogCheck {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let width = self.joints.iter().map(|j| j.coordinate.chars().count()).max().unwrap_or(0).max(5);
        let head = ["slope", "by it", "explained", "friction"];
        writeln!(f, "{:<width$}  {:>8}  {:>6}  {:>9}  {:<9}", "joint", head[0], head[1], head[2], head[3])?;
        let percent = |x: Option<f64>| x.map_or("-".into(), |x| format!("{:.0} %", 100.0 * x));
        for j in &self.joints {
            // A slope with weak evidence is in brackets or not shown.
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
