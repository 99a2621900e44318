//! A finding of a log check: a fault of the log, the joints with the fault, the evidence, and the remedy in words.
//!
//! Description: the robot description with its nominal inertial parameters. Slope: measured divided by nominal torque of a
//! joint. If the log can be explained in several ways, each explanation is a list of findings.

use std::fmt;

use crate::estimate::digits::{percent, significant};
pub use crate::estimate::hypothesis::ColumnKind;
use crate::estimate::hypothesis::Hypothesis;
use crate::estimate::log_check::change::Change;

/// A fault of a log, or a contradiction between a log and a description.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Fault {
    /// A fault that a change of the log can undo. The number is the size of the fault: an angle, rad; a delay, s; or a relative
    /// scale error. The number is 0 for a fault without a size.
    Of(Hypothesis, f64),
    /// Torques are in another unit. The number is the power of ten by which the logged numbers are too large.
    TorqueUnit(i32),
    /// Efforts are no joint torques, but currents or motor torques.
    NoTorque,
    /// The given drive gains are wrong. The number is the factor: given gain / gain implied by the description.
    Gains(f64),
    /// All torques are wrong by a common factor. The number is this factor: measured / nominal torque.
    Factor(f64),
    /// All torques have the wrong sign.
    TorqueSigns,
    /// Friction is negative. Either the torque or the motion has the wrong sign; the log does not determine which.
    FrictionSign,
    /// The base is rotated relative to its described orientation. The number is the angle, rad.
    Mount(f64),
    /// The columns of this kind of signal are in another order than the joints.
    Permuted(ColumnKind),
    /// The velocity column is not the derivative of the position.
    Velocity,
    /// The log is of another robot: no tested fault makes the description predict the torques.
    OtherRobot,
    /// Positions are normalised to the range of the joint, from the first to the second number: -100 to 100, 0 to 100, -1 to 1
    /// or 0 to 1.
    Normalised(i32, i32),
    /// Positions of a prismatic joint are in mm.
    Millimetres,
    /// Positions are far beyond the limits of the description. The numbers are the smallest and the largest position, rad (m).
    BeyondLimits(f64, f64),
    /// Something is wrong, and no tested remedy corrects it.
    Unidentified,
    /// The load of a link changes: during an interval of the log, the load differs from the load in the rest of the log.
    ChangedLoad {
        /// Number of the log, from 1; `None` if there is one log only.
        log: Option<usize>,
        /// Start, s, by the clock of the log; `None`: the first sample of the log.
        from: Option<f64>,
        /// End, s, by the clock of the log; `None`: the last sample of the log.
        to: Option<f64>,
        /// Additional mass of the load, kg (negative: less mass); `None` if not significant.
        mass: Option<f64>,
    },
    /// A link carries a load that the description does not contain. The number is the mass of the load, kg; `None` if not
    /// significant.
    OtherLoad(Option<f64>),
    /// Torques were computed from the description, not measured.
    Computed,
    /// The torques are absolute values: their signs are missing.
    AbsoluteTorque,
    /// The torque of a joint never changes, so this torque was not measured.
    DeadTorque,
    /// The torques are too small for any machine; the numbers may come from uninitialised memory. The number is the largest
    /// torque, N m (N).
    Nothing(f64),
    /// Signed integers were read as unsigned numbers.
    RawWords,
    /// Some rows come from another source than their neighbours. The number counts these rows.
    TwoSources(usize),
    /// The torque of a joint is saturated. The number is the share of the samples at the limit.
    Saturated(f64),
    /// The log is too short. The number is the largest number of periods (there and back) of a joint.
    Short(f64),
}

/// If the slopes (measured / nominal torque) of all joints are in this range, wrong nominal inertials can explain the slopes.
/// Slopes outside this range mean that the torques are in another unit.
pub(crate) const NOMINAL_INERTIAL_SLOPES: std::ops::Range<f64> = 0.25..4.0;

/// Wrong nominal inertials explain slopes (measured / nominal torque) in this range, even if the slopes of all joints are
/// equal.
pub(crate) const COMMON_FACTORS: std::ops::Range<f64> = 0.7..1.43;

/// Remedy if the torques of all joints have the wrong sign.
pub(super) const OTHER_TORQUE_SIGN: &str = "change the sign of the torque columns";

impl Fault {
    /// Whether the fault is gross, that is, makes estimates from the log unusable.
    pub fn is_gross(self) -> bool {
        let is_allowed = matches!(self, Fault::Computed | Fault::OtherLoad(_) | Fault::Saturated(_));
        !(is_allowed || matches!(self, Fault::BeyondLimits(..) | Fault::Of(Hypothesis::Late(_), _)))
    }
}

/// One finding of the log check.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// The fault.
    pub fault: Fault,
    /// Names of the coordinates with the fault; empty: all coordinates.
    pub joints: Vec<String>,
    /// The evidence in words, with its numbers.
    pub evidence: String,
    /// The correction of the fault in words: an option, a column header or a file.
    pub remedy: String,
    /// The changes of the log that undo the fault; empty if no change of the log undoes it.
    pub undo: Vec<Change>,
    /// Squared relative residual of the description, mean over the joints: [without, with] the remedy. `None` if the remedy
    /// was not tried or did not remove all contradictions.
    pub tried: Option<[f64; 2]>,
    /// Number of the explanation of the log to which the finding belongs: 0 for the first explanation; 1, 2, .. for alternative
    /// explanations. Only one explanation is right, but the log does not determine which.
    pub instead: usize,
}

impl Finding {
    /// Makes a finding on all joints.
    pub(crate) fn of_all(fault: Fault, evidence: String, remedy: impl Into<String>) -> Finding {
        Finding::of(fault, Vec::new(), evidence, remedy)
    }

    /// Makes a finding on these joints (empty: on all joints), without changes of the log that undo the fault.
    pub fn of(fault: Fault, joints: Vec<String>, evidence: String, remedy: impl Into<String>) -> Finding {
        Finding { fault, joints, evidence, remedy: remedy.into(), undo: Vec::new(), tried: None, instead: 0 }
    }

    /// Adds the changes of the log that undo the fault.
    pub(super) fn undone_by(self, undo: Vec<Change>) -> Finding {
        Finding { undo, ..self }
    }

    /// Whether the fault is a wrong scale of the torques of all joints (unit, currents, common factor).
    pub(super) fn is_of_scale(&self) -> bool {
        matches!(self.fault, Fault::NoTorque | Fault::TorqueUnit(_) | Fault::Factor(_))
    }

    /// A sentence with the fault and its joints.
    pub fn statement(&self) -> String {
        let of = self.joints.join(", ");
        match self.fault {
            // A fault that is also a hypothesis has its sentence in `hypothesis`. Here the size of the fault gets a usual unit
            // (ms, per cent, degrees). The other faults exist only in the log check.
            Fault::Of(hypothesis, size) => {
                let off = match hypothesis {
                    Hypothesis::Late(_) => format!("{:.0} ms", 1e3 * size),
                    Hypothesis::Scale(_) => percent(size),
                    _ => format!("{:.0} degrees", size.to_degrees()),
                };
                hypothesis.statement(&off, &self.joints.iter().map(String::as_str).collect::<Vec<_>>())
            }
            Fault::TorqueUnit(power) => {
                let unit = torque_unit(power);
                format!("the torques are in another unit: 10^{power} times those of the description{unit}")
            }
            Fault::NoTorque => {
                "the efforts are no torques of the joints: currents (A), or torques of the motors".into()
            }
            Fault::Gains(factor) => {
                format!("the drive gains are {} times those that the description implies", significant(factor))
            }
            Fault::Factor(factor) => {
                format!("the torques are about {} times those of the description, at all joints", significant(factor))
            }
            Fault::TorqueSigns => "the torques of all joints have the wrong sign".into(),
            Fault::FrictionSign => format!("friction drives {of}: the sign of its torque or of its position is wrong"),
            Fault::Mount(angle) => {
                format!("the base is mounted otherwise: turned by {:.0} degrees", angle.to_degrees())
            }
            Fault::Permuted(columns) => format!("the columns of {of} are in another order ({})", quantities(columns)),
            Fault::Velocity => format!("the velocity of {of} is not the slope of its position"),
            Fault::OtherRobot => "this log is not of the described robot".into(),
            Fault::Unidentified => format!("something is wrong at {of}; its cause is not identified"),
            Fault::Normalised(from, to) => normalised(from, to, &of),
            Fault::Millimetres => format!("the position of {of} is in mm"),
            Fault::BeyondLimits(low, high) => {
                format!("{of} moves from {} to {}, beyond its limits", significant(low), significant(high))
            }
            Fault::ChangedLoad { log, from, to, mass } => {
                format!("{of} carries another load{}{}", of_interval(log, from, to), of_mass(mass))
            }
            Fault::OtherLoad(mass) => format!("{of} carries another load than in the description{}", of_mass(mass)),
            Fault::Computed => "the torques are computed from this description, not measured".into(),
            Fault::AbsoluteTorque => "the torques are absolute values: their sign is missing".into(),
            Fault::DeadTorque => format!("the torque of {of} is not measured: it never changes"),
            Fault::Nothing(largest) => format!("the torque of {of} is nothing: {largest:.1e} at most"),
            Fault::RawWords => format!("numbers of {of} were read without their sign"),
            Fault::TwoSources(rows) => format!("{rows} rows are of another source than the rows around them"),
            Fault::Saturated(share) => {
                format!("the torque of {of} stands at its limit in {:.0} % of the rows", 100.0 * share)
            }
            Fault::Short(periods) => {
                format!("the log is too short: no joint goes there and back more than {periods:.1} times")
            }
        }
    }
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let instead = if self.instead > 0 { "or else " } else { "" };
        write!(f, "{instead}{}: {}; {}", self.statement(), self.evidence, self.remedy)
    }
}

/// The quantities of columns, in words.
fn quantities(columns: ColumnKind) -> &'static str {
    match columns {
        ColumnKind::All => "position, velocity and torque",
        ColumnKind::Motions => "position and velocity",
        ColumnKind::Torques => "torque",
    }
}

/// Positions that are normalised between these numbers, in words. `of`: names of the joints; empty: all joints.
fn normalised(from: i32, to: i32, of: &str) -> String {
    match of {
        "" => format!("the positions are normalised: {from} to {to} of the range of each joint"),
        _ => format!("the position of {of} is normalised: {from} to {to} of its range"),
    }
}

/// An interval of a log in words, with a leading blank; empty for the whole of one log.
fn of_interval(log: Option<usize>, from: Option<f64>, to: Option<f64>) -> String {
    let log = log.map_or(String::new(), |log| format!(" in log {log}"));
    let from = from.map_or(String::new(), |t| format!(" from {t:.1} s on"));
    let to = to.map_or(String::new(), |t| format!(" up to {t:.1} s"));
    from + &to + &log
}

/// The additional mass of a load in words, with a leading comma; empty if unknown.
fn of_mass(mass: Option<f64>) -> String {
    let more = |mass: f64| if mass > 0.0 { "more" } else { "less" };
    mass.map_or(String::new(), |m| format!(", about {} kg {}", significant(m.abs()), more(m)))
}

/// The name of the torque unit N m / 10^power in brackets, such as ` (N mm)` for 3; empty if this unit has no name.
fn torque_unit(power: i32) -> &'static str {
    match power {
        3 => " (N mm)",
        2 => " (N cm)",
        -3 => " (kN m)",
        _ => "",
    }
}
