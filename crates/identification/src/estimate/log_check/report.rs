//! Holds the result of a log check: agreement of each joint with the robot description, findings, and what could not be
//! checked.
//!
//! Slope: regression slope of the measured on the nominal torque of a joint, near 1 in agreement. Misfit: relative squared
//! error with which the description predicts the torques. Undoing a fault: changing the log so that the fault disappears.

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
    /// Regression slope of the measured on the nominal torque, with rotor, friction and offset projected out; near 1 in
    /// agreement. `None` without inertials, or if the joint has too few samples.
    pub slope: Option<f64>,
    /// Share, 0 to 1, that the nominal torque explains of the squared residual of a fit by rotor, friction and offset. The
    /// slope is meaningful only if this share is large. `None` in the same cases as `slope`.
    pub share: Option<f64>,
    /// Share of the variance of the torque that nominal torque, rotor, friction and offset explain together, 0 to 1; `None`
    /// if unknown.
    pub explained: Option<f64>,
    /// Friction, fitted to the torques of this joint alone; `None` if it cannot be determined.
    pub friction: Option<JointFriction>,
    /// Smallest and largest position of the joint in the log, rad (m).
    pub positions: (f64, f64),
    /// Lag of the velocity behind the derivative of the position, s. `None` if the joint hardly moves, or if the velocity is
    /// another signal.
    pub velocity_lag: Option<f64>,
    /// Standard deviation of `velocity_lag`, s.
    pub velocity_lag_deviation: f64,
    /// Correlation of the acceleration with the derivative of the velocity, and the ratio of their rms values. `None` if the
    /// acceleration or the derivative is zero.
    pub acceleration: Option<(f64, f64)>,
    /// Whether the acceleration is not the derivative of the velocity but another signal.
    pub wrong_acceleration: bool,
    /// The smallest zero offset of the joint that would have been detected, rad; `None` if no offset would have been detected.
    pub zero_power: Option<f64>,
}

/// For velocities and accelerations, whether they come from columns of the log (true) or are computed as derivatives (false).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Measured {
    /// Whether velocities come from columns of the log.
    pub velocity: bool,
    /// Whether accelerations come from columns of the log.
    pub acceleration: bool,
}

/// A suspected fault that is not needed, because other bodies than the nominal bodies explain the log equally well.
#[derive(Clone, Debug, PartialEq)]
pub struct ExplainedMistake {
    /// The suspected fault, as a finding.
    pub finding: Finding,
    /// Whether undoing the fault makes the description predict the log far better.
    pub is_likely: bool,
}

/// The result of the check of a log against a description, before any fit.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LogCheck {
    /// Agreement of each joint with the description, one per coordinate.
    pub joints: Vec<JointCheck>,
    /// The findings. Gross findings, which make estimates unusable, come first.
    pub findings: Vec<Finding>,
    /// Alternatives to `findings`: other explanations of the log, each a list of findings. Empty after they were tried.
    pub others: Vec<Vec<Finding>>,
    /// Suspected faults that are not needed, because other bodies than the nominal bodies explain the log equally well.
    pub explained: Vec<ExplainedMistake>,
    /// A constant load that the description does not contain; `None` if none was found. Such a load is no fault of the log, but
    /// becomes part of the parameters.
    pub load: Option<Finding>,
    /// Sentences on intervals in which the residual is an outlier.
    pub contacts: Vec<String>,
    /// Sentences on properties that could not be checked.
    pub not_checked: Vec<String>,
    /// Whether the motion is short. In a short motion, a fault is reported only if it explains nearly the whole misfit (error
    /// of the description).
    pub is_short: bool,
    /// The states (positions and velocities) that the robot visited.
    pub visited: VisitedStates,
    /// Whether velocity and acceleration columns of the log were used.
    pub measured: Measured,
    /// The joint whose zero offset makes the description fit far better; `None` if no joint has such an offset.
    pub turned: Option<MisplacedJoint>,
    /// Pairs of joints, or of limbs (chains of joints), whose exchange would not be detected. Each member of a pair is a list of
    /// joints.
    pub hidden_exchanges: Vec<[Vec<usize>; 2]>,
    /// Whether columns are assigned to joints by their place, not by their names.
    pub is_by_place: bool,
}

/// A slope is not printed if the description explains less than this share of the torque.
const SHOWN_SLOPE_SHARE: f64 = 0.05;

impl JointCheck {
    /// Range of the positions of the joint, rad (m).
    pub fn range(&self) -> f64 {
        self.positions.1 - self.positions.0
    }

    /// Whether torque or motion of the joint clearly has the wrong sign: friction is negative, and a meaningful slope is
    /// negative too.
    pub(super) fn runs_back(&self) -> bool {
        let is_negative = self.slope.is_some_and(|slope| slope < 0.0);
        let is_meaningful = self.share.is_some_and(|share| share > COUNTED_SLOPE_SHARE);
        is_negative && is_meaningful && self.friction.is_some_and(|f| f.drives)
    }

    /// Magnitude of the slope of the joint and, as text such as `q1=11.5`, the drive gain that the description implies. `gain`:
    /// the gain that was used, N m/A. `None` if the slope is not meaningful.
    fn implied_gain(&self, gain: f64) -> Option<(f64, String)> {
        let slope = self.slope.filter(|_| self.share.is_some_and(|share| share > COUNTED_SLOPE_SHARE))?.abs();
        Some((slope, format!("{}={}", self.coordinate, significant(gain / slope))))
    }
}

fn by_description(gains: &[String]) -> String {
    format!("by the description about [gain={}], as far as its masses are right", gains.join(","))
}

impl LogCheck {
    /// Replaces the results on velocity and acceleration columns by the results of `other`, another check of the same log.
    pub fn with_columns_of(mut self, other: LogCheck) -> LogCheck {
        self.measured = other.measured;
        // If a lag was found, the velocity column is a late derivative of the position. If no lag was found, the velocity
        // column belongs to another joint, or is another signal.
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

    /// Lag of the velocities behind the derivatives of the positions, s: the median over the joints, because one filter acts on
    /// the velocities of all joints. `None` if no joint has a lag.
    pub fn velocity_lag(&self) -> Option<f64> {
        let mut lags: Vec<f64> = self.joints.iter().filter_map(|j| j.velocity_lag).collect();
        lags.sort_by(f64::total_cmp);
        lags.get(lags.len() / 2).copied()
    }

    /// Whether the log was compared with inertials of the description.
    pub(crate) fn has_description(&self) -> bool {
        self.joints.iter().any(|j| j.slope.is_some())
    }

    /// Whether a finding makes estimates from this log unusable.
    pub fn is_gross(&self) -> bool {
        self.findings.iter().any(|f| f.fault.is_gross())
    }

    /// Compares the given drive gains with the gains that the description implies, and adds a finding if they differ.
    /// `gains`: one per coordinate, N m/A.
    ///
    /// If the torque of a joint is s times the nominal torque, the given gain of this joint is s times too large.
    pub fn gains_are(&mut self, gains: &[f64]) {
        let all = self.joints.iter().zip(gains);
        let mut found: Vec<(f64, String)> = all.filter_map(|(joint, gain)| joint.implied_gain(*gain)).collect();
        let implied: Vec<String> = found.iter().map(|(_, text)| text.clone()).collect();
        found.sort_by(|a, b| a.0.total_cmp(&b.0));
        let Some(factor) = found.get(found.len() / 2).map(|f| f.0).filter(|_| found.len() >= gains.len().min(2)) else {
            return;
        };
        self.findings.retain(|f| !f.is_of_scale());
        // A load or other bodies would change only some of the slopes.
        let all = |is_off: &dyn Fn(f64) -> bool| found.iter().all(|(slope, _)| is_off(*slope));
        let is_off = all(&|s| s > COMMON_FACTORS.end) || all(&|s| s < COMMON_FACTORS.start);
        let is_off = is_off || !NOMINAL_INERTIAL_SLOPES.contains(&factor);
        if self.findings.is_empty() && is_off {
            let texts: Vec<String> = found.iter().map(|(slope, _)| significant(*slope)).collect();
            let evidence = format!("measured over nominal torque, by joint: {}", texts.join(" "));
            self.findings.push(Finding::of_all(Fault::Gains(factor), evidence, by_description(&implied)));
        }
    }

    /// For efforts that are known to be currents: moves findings on the torque unit to `not_checked`, because these findings
    /// are no faults. The text contains the gains that the description implies.
    pub fn efforts_are_currents(&mut self) {
        let unit: Vec<Finding> = self.findings.extract_if(.., |f| f.is_of_scale()).collect();
        self.not_checked.extend(unit.iter().map(|f| format!("currents without gains: {}; {}", f.evidence, f.remedy)));
    }

    /// For position errors that were used as torques with gains of 1: removes findings on the torque unit, and adds the gains
    /// that the description implies to `not_checked`. `scale`: a sentence on the meaning of the torques.
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
            // If the description explains little of the torque, the slope is printed in brackets or not at all.
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
