//! What a passport says: a fault, the joints that have it, the numbers that show it, and what mends it.

use std::fmt;

use crate::estimate::digits::significant;

/// What is wrong with a log, or with a log and a description together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Fault {
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
    /// The torque of a joint has the other sign.
    TorqueSign,
    /// Position and velocity of a joint have the other sign.
    MotionSign,
    /// Motion and torque have the other sign.
    Reversed,
    /// Friction drives, so the sign of the torque or of the motion is wrong; which of them cannot be told.
    FrictionSign,
    /// The position of the description minus that of the log, rad.
    Zero(f64),
    /// All signals of two joints are swapped.
    SwappedJoints,
    /// The base is mounted otherwise: turned by this angle, rad.
    Mount(f64),
    /// Columns are in another order than the joints.
    Permuted(Columns),
    /// Positions and velocities of two joints are swapped.
    SwappedMotions,
    /// The positions of two joints are swapped, velocities as they are.
    SwappedPositions,
    /// The velocities of two joints are swapped, positions as they are.
    SwappedVelocities,
    /// The torques of two joints are swapped.
    SwappedTorques,
    /// The velocity is not the slope of the position.
    Velocity,
    /// The torques lag the positions by so many seconds.
    Delay(f64),
    /// Gravity was taken out of the torques before they were logged.
    GravityCompensated,
    /// Nothing tried makes the description predict the torques.
    OtherRobot,
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
    /// Angles in degrees, taken for radians.
    Degrees,
    /// Largest number of periods that a joint makes.
    Short(f64),
}

/// Common slopes within these are errors of nominal inertials, not another unit.
pub(crate) const NOMINAL_INERTIAL_SLOPES: std::ops::Range<f64> = 0.25..4.0;

/// Slopes of all joints within these may be errors of nominal inertials, even where they are alike.
pub(crate) const COMMON_FACTORS: std::ops::Range<f64> = 0.7..1.43;

/// The columns of a log that share an order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Columns {
    /// Positions, velocities and torques.
    All,
    /// Positions and velocities.
    Motions,
    /// Torques.
    Torques,
}

impl Fault {
    /// Whether no estimate from such a log can be used.
    pub fn is_gross(self) -> bool {
        !matches!(self, Fault::Computed | Fault::Saturated(_) | Fault::Delay(_))
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
}

impl Finding {
    /// What is wrong, in words.
    pub fn statement(&self) -> String {
        let of = self.joints.join(", ");
        let pair = self.joints.join(" and ");
        match self.fault {
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
            Fault::TorqueSign => format!("the torque of {of} has the wrong sign"),
            Fault::MotionSign => format!("the position of {of} has the wrong sign"),
            Fault::Reversed => format!("{of} runs the other way round: position and torque have the wrong sign"),
            Fault::FrictionSign => format!("friction drives {of}: the sign of its torque or of its position is wrong"),
            Fault::Zero(angle) => format!("the zero of {of} is off by {:.0} degrees", angle.to_degrees()),
            Fault::Mount(angle) => {
                format!("the base is mounted otherwise: turned by {:.0} degrees", angle.to_degrees())
            }
            Fault::SwappedJoints => format!("the columns of {pair} are swapped (position, velocity and torque)"),
            Fault::Permuted(columns) => {
                let what = match columns {
                    Columns::All => "position, velocity and torque",
                    Columns::Motions => "position and velocity",
                    Columns::Torques => "torque",
                };
                format!("the columns of {of} are in another order ({what})")
            }
            Fault::SwappedMotions => format!("the columns of {pair} are swapped (position and velocity)"),
            Fault::SwappedPositions => format!("the position columns of {pair} are swapped"),
            Fault::SwappedVelocities => format!("the velocity columns of {pair} are swapped"),
            Fault::SwappedTorques => format!("the torque columns of {pair} are swapped"),
            Fault::Velocity => format!("the velocity of {of} is not the slope of its position"),
            Fault::Delay(seconds) if seconds > 0.0 => {
                format!("the torques come {:.0} ms later than the positions", 1e3 * seconds)
            }
            Fault::Delay(seconds) => format!("the torques come {:.0} ms before the positions", -1e3 * seconds),
            Fault::GravityCompensated => {
                "gravity is not in the torques: it was taken out before they were logged".into()
            }
            Fault::OtherRobot => "this log is not of this robot as it is described".into(),
            Fault::Computed => "the torques are computed from this description, not measured".into(),
            Fault::DeadTorque => format!("the torque of {of} is not measured: it never changes"),
            Fault::Nothing(largest) => format!("the torque of {of} is nothing: {largest:.1e} at most"),
            Fault::RawWords => format!("numbers of {of} were read without their sign"),
            Fault::TwoSources(rows) => format!("{rows} rows are of another source than the rows around them"),
            Fault::Saturated(share) => {
                format!("the torque of {of} stands at its limit in {:.0} % of the rows", 100.0 * share)
            }
            Fault::Degrees => format!("{of} in degrees, taken for radians"),
            Fault::Short(periods) => {
                format!("the log is too short: no joint goes there and back more than {periods:.1} times")
            }
        }
    }
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}; {}", self.statement(), self.evidence, self.remedy)
    }
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
