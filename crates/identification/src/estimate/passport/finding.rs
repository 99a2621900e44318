//! What a passport says: a fault, the joints that have it, the numbers that show it, and what mends it.

use std::fmt;

use crate::estimate::digits::{percent, significant};
pub use crate::estimate::hypothesis::Columns;
use crate::estimate::hypothesis::Hypothesis;
use crate::estimate::passport::change::Change;

/// What is wrong with a log, or with a log and a description together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Fault {
    /// One that a change of the log undoes, and its size: an angle (rad) or a delay (s), else 0.
    Of(Hypothesis, f64),
    /// Torques in another unit: so many powers of ten too large.
    TorqueUnit(i32),
    /// Efforts that are no torques of the joints: currents, or torques of motors.
    NoTorque,
    /// Drive gains so many times those that the description implies.
    Gains(f64),
    /// Torques so many times those of the description, at all joints alike.
    Factor(f64),
    /// All torques have the other sign.
    TorqueSigns,
    /// Friction drives, so the sign of the torque or of the motion is wrong; which of them cannot be told.
    FrictionSign,
    /// The base is mounted otherwise: turned by this angle, rad.
    Mount(f64),
    /// Columns are in another order than the joints.
    Permuted(Columns),
    /// The velocity is not the slope of the position.
    Velocity,
    /// Nothing tried makes the description predict the torques.
    OtherRobot,
    /// Positions are shares of the range of each joint, -100 to 100.
    Normalised,
    /// Something is wrong, and nothing that was tried mends it.
    Unidentified,
    /// A link carries another load than in the rest of the log.
    ChangedLoad {
        /// Which of several logs, from 1.
        log: Option<usize>,
        /// s by the clock of the log; `None`: from its first sample on.
        from: Option<f64>,
        /// s; `None`: to its last sample.
        to: Option<f64>,
        /// kg, where it is significant.
        mass: Option<f64>,
    },
    /// A link carries another load than the description has; its mass, kg, where it is significant.
    OtherLoad(Option<f64>),
    /// Torques computed from the description, not measured.
    Computed,
    /// A torque that never changes.
    DeadTorque,
    /// A torque so small that no machine gives it: memory that nobody wrote.
    Nothing(f64),
    /// Numbers of a register, read without their sign.
    RawWords,
    /// So many rows are of another source than those around them.
    TwoSources(usize),
    /// The torque stands at a limit in this share of the samples.
    Saturated(f64),
    /// Largest number of periods that a joint makes.
    Short(f64),
}

/// Common slopes within these are errors of nominal inertials, not another unit.
pub(crate) const NOMINAL_INERTIAL_SLOPES: std::ops::Range<f64> = 0.25..4.0;

/// Slopes of all joints within these may be errors of nominal inertials, even where they are alike.
pub(crate) const COMMON_FACTORS: std::ops::Range<f64> = 0.7..1.43;

/// What mends torques that all have the wrong sign.
pub(super) const OTHER_TORQUE_SIGN: &str = "change the sign of the torque columns";

impl Fault {
    /// Whether no estimate from such a log can be used.
    pub fn is_gross(self) -> bool {
        !matches!(self, Fault::Computed | Fault::OtherLoad(_) | Fault::Saturated(_) | Fault::Of(Hypothesis::Late(_), _))
    }
}

/// One finding.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// What is wrong.
    pub fault: Fault,
    /// The coordinates that have it; empty: all of them.
    pub joints: Vec<String>,
    /// The numbers that show it.
    pub evidence: String,
    /// The option, the header or the file that mends it.
    pub remedy: String,
    /// The changes of the log that undo it; none where the log alone does not mend it.
    pub undo: Vec<Change>,
    /// Share of the torques that the description leaves, joints alike and in squares, without the remedy and with it: it was
    /// applied, and nothing is contradicted any more.
    pub tried: Option<[f64; 2]>,
    /// 0, or the number of another explanation, which mends the log in place of the findings of 0: the log does not tell
    /// which it is.
    pub instead: usize,
}

impl Finding {
    /// One of all joints.
    pub(crate) fn of_all(fault: Fault, evidence: String, remedy: impl Into<String>) -> Finding {
        Finding::of(fault, Vec::new(), evidence, remedy)
    }

    /// One of some joints, that no change of the log undoes.
    pub fn of(fault: Fault, joints: Vec<String>, evidence: String, remedy: impl Into<String>) -> Finding {
        Finding { fault, joints, evidence, remedy: remedy.into(), undo: Vec::new(), tried: None, instead: 0 }
    }

    /// The same with the changes of the log that undo it.
    pub(super) fn undone_by(self, undo: Vec<Change>) -> Finding {
        Finding { undo, ..self }
    }

    /// Whether it is about the unit of all efforts.
    pub(super) fn is_of_scale(&self) -> bool {
        matches!(self.fault, Fault::NoTorque | Fault::TorqueUnit(_) | Fault::Factor(_))
    }

    /// What is wrong, in words.
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
                    Columns::All => "position, velocity and torque",
                    Columns::Motions => "position and velocity",
                    Columns::Torques => "torque",
                };
                format!("the columns of {of} are in another order ({what})")
            }
            Fault::Velocity => format!("the velocity of {of} is not the slope of its position"),
            Fault::OtherRobot => "this log is not of this robot as it is described".into(),
            Fault::Unidentified => format!("something is wrong at {of}; its cause is not identified"),
            Fault::Normalised => "the positions are normalised: -100 to 100 of the range of each joint".into(),
            Fault::ChangedLoad { log, from, to, mass } => {
                let log = log.map_or(String::new(), |log| format!(" in log {log}"));
                let from = from.map_or(String::new(), |t| format!(" from {t:.1} s on"));
                let to = to.map_or(String::new(), |t| format!(" up to {t:.1} s"));
                format!("{of} carries another load{from}{to}{log}{}", of_mass(mass))
            }
            Fault::OtherLoad(mass) => format!("{of} carries another load than described{}", of_mass(mass)),
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

/// What a load weighs more than another, behind a comma.
fn of_mass(mass: Option<f64>) -> String {
    let more = |mass: f64| if mass > 0.0 { "more" } else { "less" };
    mass.map_or(String::new(), |m| format!(", about {} kg {}", significant(m.abs()), more(m)))
}

/// The unit in which torques are so many powers of ten too large, behind a blank.
fn torque_unit(power: i32) -> &'static str {
    match power {
        3 => " (N mm)",
        2 => " (N cm)",
        -3 => " (kN m)",
        _ => "",
    }
}
