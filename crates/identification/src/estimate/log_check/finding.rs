//! A finding of a log check: a fault, the joints that have it, the evidence, and the remedy.

use std::fmt;

use crate::estimate::digits::{percent, significant};
pub use crate::estimate::hypothesis::ColumnKind;
use crate::estimate::hypothesis::Hypothesis;
use crate::estimate::log_check::change::Change;

/// A fault of a log, or a contradiction between a log and a description.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Fault {
    /// A fault that a change of the log undoes, and its size: an angle (rad), a delay (s) or a scale, else 0.
    Of(Hypothesis, f64),
    /// Torques in another unit, too large by this power of ten.
    TorqueUnit(i32),
    /// Efforts that are not torques of the joints: currents, or torques of motors.
    NoTorque,
    /// Drive gains over the gains that the description implies.
    Gains(f64),
    /// Measured torques over nominal torques, common to all joints.
    Factor(f64),
    /// All torques have the other sign.
    TorqueSigns,
    /// Negative friction, so the sign of the torque or of the motion is wrong; which one cannot be determined.
    FrictionSign,
    /// The orientation of the base differs from the description by this angle, rad.
    Mount(f64),
    /// Columns are in another order than the joints.
    Permuted(ColumnKind),
    /// The velocity is not the derivative of the position.
    Velocity,
    /// No tested fault makes the description predict the torques.
    OtherRobot,
    /// Positions are shares of the range of each joint, -100 to 100.
    Normalised,
    /// Something is wrong, and no tested remedy corrects it.
    Unidentified,
    /// During a part of the log a link carries another load.
    ChangedLoad {
        /// Number of the log where there are several, from 1.
        log: Option<usize>,
        /// Start, s, by the clock of the log; `None`: its first sample.
        from: Option<f64>,
        /// End, s, by the clock of the log; `None`: its last sample.
        to: Option<f64>,
        /// Mass, kg, where significant.
        mass: Option<f64>,
    },
    /// A link carries a load that the description does not have; its mass, kg, where significant.
    OtherLoad(Option<f64>),
    /// Torques computed from the description, not measured.
    Computed,
    /// A torque that never changes.
    DeadTorque,
    /// The largest torque, N m (N), too small for any machine: uninitialised memory.
    Nothing(f64),
    /// Numbers of a register, read without their sign.
    RawWords,
    /// Number of rows from another source than the rows around them.
    TwoSources(usize),
    /// Share of the samples in which the torque is at its limit.
    Saturated(f64),
    /// The log is too short: the largest number of periods of a joint.
    Short(f64),
}

/// A common slope in this range is an error of nominal inertials, not another unit.
pub(crate) const NOMINAL_INERTIAL_SLOPES: std::ops::Range<f64> = 0.25..4.0;

/// Slopes of all joints in this range may be errors of nominal inertials, even where the slopes are equal.
pub(crate) const COMMON_FACTORS: std::ops::Range<f64> = 0.7..1.43;

/// Remedy for torques of all joints with the wrong sign.
pub(super) const OTHER_TORQUE_SIGN: &str = "change the sign of the torque columns";

impl Fault {
    /// Whether estimates from such a log are unusable.
    pub fn is_gross(self) -> bool {
        !matches!(self, Fault::Computed | Fault::OtherLoad(_) | Fault::Saturated(_) | Fault::Of(Hypothesis::Late(_), _))
    }
}

/// One finding.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// The fault.
    pub fault: Fault,
    /// The coordinates that have it; empty: all of them.
    pub joints: Vec<String>,
    /// The numbers that show it.
    pub evidence: String,
    /// The option, the header or the file that corrects it.
    pub remedy: String,
    /// The changes of the log that undo it; empty where changes of the log do not correct it.
    pub undo: Vec<Change>,
    /// Squared relative residual of the description, mean over joints, without the remedy and with it. Present where the
    /// remedy was applied and no contradiction remained.
    pub tried: Option<[f64; 2]>,
    /// 0, or the number of an alternative explanation, which corrects the log in place of the findings with 0. The log does
    /// not determine which one is right.
    pub instead: usize,
}

impl Finding {
    /// A finding of all joints.
    pub(crate) fn of_all(fault: Fault, evidence: String, remedy: impl Into<String>) -> Finding {
        Finding::of(fault, Vec::new(), evidence, remedy)
    }

    /// A finding of some joints, without changes that undo it.
    pub fn of(fault: Fault, joints: Vec<String>, evidence: String, remedy: impl Into<String>) -> Finding {
        Finding { fault, joints, evidence, remedy: remedy.into(), undo: Vec::new(), tried: None, instead: 0 }
    }

    /// The finding with the changes of the log that undo it.
    pub(super) fn undone_by(self, undo: Vec<Change>) -> Finding {
        Finding { undo, ..self }
    }

    /// Whether it concerns the unit of all efforts.
    pub(super) fn is_of_scale(&self) -> bool {
        matches!(self.fault, Fault::NoTorque | Fault::TorqueUnit(_) | Fault::Factor(_))
    }

    /// A sentence on the fault.
    pub fn statement(&self) -> String {
        let of = self.joints.join(", ");
        match self.fault {
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
            Fault::Permuted(columns) => {
                let what = match columns {
                    ColumnKind::All => "position, velocity and torque",
                    ColumnKind::Motions => "position and velocity",
                    ColumnKind::Torques => "torque",
                };
                format!("the columns of {of} are in another order ({what})")
            }
            Fault::Velocity => format!("the velocity of {of} is not the slope of its position"),
            Fault::OtherRobot => "this log is not of the described robot".into(),
            Fault::Unidentified => format!("something is wrong at {of}; its cause is not identified"),
            Fault::Normalised => "the positions are normalised: -100 to 100 of the range of each joint".into(),
            Fault::ChangedLoad { log, from, to, mass } => {
                let log = log.map_or(String::new(), |log| format!(" in log {log}"));
                let from = from.map_or(String::new(), |t| format!(" from {t:.1} s on"));
                let to = to.map_or(String::new(), |t| format!(" up to {t:.1} s"));
                format!("{of} carries another load{from}{to}{log}{}", of_mass(mass))
            }
            Fault::OtherLoad(mass) => format!("{of} carries another load than in the description{}", of_mass(mass)),
            Fault::Computed => "the torques are computed from this description, not measured".into(),
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

/// The additional mass of a load in words, after a comma; empty where unknown.
fn of_mass(mass: Option<f64>) -> String {
    let more = |mass: f64| if mass > 0.0 { "more" } else { "less" };
    mass.map_or(String::new(), |m| format!(", about {} kg {}", significant(m.abs()), more(m)))
}

/// The unit in which torques are too large by this power of ten, after a space; empty where none is common.
fn torque_unit(power: i32) -> &'static str {
    match power {
        3 => " (N mm)",
        2 => " (N cm)",
        -3 => " (kN m)",
        _ => "",
    }
}
