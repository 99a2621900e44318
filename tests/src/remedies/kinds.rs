//! The kinds of mistakes in logs. [`KINDS`] has one line for each.
//!
//! A claim of the program is a line such as `agrees: zero of j2; 20 deg would have shown`: its topic (zero), its joint, and the
//! size that would have been detected.

use std::f64::consts::{FRAC_PI_2, PI};

/// A change of a log, or of the machine while it is logged. For a kind that concerns one or two joints, these are drawn at
/// random.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    /// Zero error of a joint, degrees.
    Zero(f64),
    /// Position and velocity of a joint have the wrong sign.
    MotionSign,
    /// The torque of a joint has the wrong sign.
    TorqueSign,
    /// Position, velocity and torque of a joint have the wrong sign.
    Reversed,
    /// The torques of all joints have the wrong sign.
    AllTorqueSigns,
    /// Positions and velocities of two joints are exchanged.
    SwappedMotions,
    /// Only the velocities of two joints are exchanged.
    SwappedVelocities,
    /// Only the torques of two joints are exchanged.
    SwappedTorques,
    /// All columns of two joints are exchanged.
    SwappedColumns,
    /// The columns of each joint have the name of the next joint.
    Rotated,
    /// All angles and angular velocities are in degrees.
    Degrees,
    /// All torques are too large by this factor.
    AllScaled(f64),
    /// The torque of a joint is too large by this factor.
    Scaled(f64),
    /// The torque of one joint is half of the true torque, and the torque of another joint is three times the true one.
    TwoScaled,
    /// The torque columns contain currents, and the drive gains of the joints differ.
    Currents,
    /// The torques are delayed by this time, ms.
    Late(f64),
    /// The base is rotated by roll, pitch and yaw, rad.
    Base([f64; 3]),
    /// The gravity torque of the bodies was subtracted.
    GravityOut,
    /// A spring. At the end of the joint's motion its torque is half of the joint's rms torque.
    Spring,
    /// The last link carries an additional load.
    Payload,
    /// The last link carries an additional load in the second half of the log.
    LoadPickedUp,
    /// The log is from another robot with the same number of joints.
    OtherRobot,
    /// The torque of a joint is constant, as from a broken sensor.
    DeadTorque,
    /// The torque of a joint is limited to 60 % of its largest value.
    Saturated,
    /// The velocities are filtered by a first-order low-pass with this cut-off, Hz.
    FilteredVelocities(f64),
    /// Each position is scaled to -100 .. 100 over the range of the joint.
    Normalised,
    /// During 1 s, a contact adds 30 % of the rms torque to a joint.
    Contact,
    /// The torque of a joint grows by 25 % from the first to the last sample.
    Drift,
    /// The torques were computed from the description instead of measured.
    Computed,
}

impl Kind {
    /// Whether the mistake is in the machine and not in the columns: the logged torques are the true motor torques at the times
    /// of the log.
    pub fn is_of_machine(self) -> bool {
        matches!(
            self,
            Kind::Base(_) | Kind::Spring | Kind::Payload | Kind::LoadPickedUp | Kind::Contact | Kind::OtherRobot
        )
    }
}

/// A mistake, and the joints that it concerns.
#[derive(Clone, Copy, Debug)]
pub struct Mistake {
    /// The kind of the mistake.
    pub kind: Kind,
    /// The joint with the mistake, or the first of two joints.
    pub a: usize,
    /// The second of two joints.
    pub b: usize,
    /// A random number in [0, 1) from which other properties of the mistake follow.
    pub more: f64,
}

/// A kind of mistake, and how the output of the program refers to it.
pub struct Entry {
    /// Name of the kind.
    pub name: &'static str,
    /// The kind, with its size.
    pub kind: Kind,
    /// Phrases in a finding that name this kind; one of them is enough. `{a}` and `{b}` stand for the names of the joints.
    pub right: &'static [&'static str],
    /// The first word of claims about this kind (`agrees: zero of j2; 20 deg would have shown`).
    pub topic: &'static str,
    /// The size of the mistake in the unit that these claims use; `None` if it depends on the machine.
    pub size: Option<f64>,
    /// Whether the mistake must be found although the program states no detection limit for its kind.
    pub is_gross: bool,
}

const GROSS: bool = true;
const SMALL: bool = false;

const fn kind(
    name: &'static str,
    kind: Kind,
    right: &'static [&'static str],
    topic: &'static str,
    size: Option<f64>,
    is_gross: bool,
) -> Entry {
    Entry { name, kind, right, topic, size, is_gross }
}

const ZERO: &[&str] = &["the zero of {a} is off by"];
const OF_SIGN: &[&str] =
    &["the torque of {a} has the wrong sign", "the position of {a} has the wrong sign", "friction drives {a}:"];
const MOTION_SIGN: &[&str] = &[OF_SIGN[1], OF_SIGN[2]];
const TORQUE_SIGN: &[&str] = &[OF_SIGN[0], OF_SIGN[2]];
const SCALE: &[&str] = &["the torque of {a} is off by", "the torque of {a} is about"];
const TWO_SCALES: &[&str] =
    &["the torque of {a} is off by", "the torque of {b} is off by", "of {a} is about", "of {b} is about"];
const FACTOR: &[&str] = &["the torques are about", "the efforts are no torques", "times those of the description"];
const CURRENTS: &[&str] = &["the efforts are no torques"];
const LATE: &[&str] = &["later than the positions", "is late by"];
const MOUNT: &[&str] = &["the base is mounted otherwise", "gravity is tilted by"];
const LOAD: &[&str] = &["load", "another tool", "other bodies"];
const ROTATED: &[&str] = &["in another order (position, velocity and torque)"];
const MOTIONS: &[&str] =
    &["the columns of {a} and {b} are swapped (position and velocity)", "position columns of {a} and {b}"];
const VELOCITIES: &[&str] = &[
    "velocity columns of {a} and {b}",
    "the velocity of {a} is not the slope",
    "the velocity of {b} is not the slope",
];
const COLUMNS: &[&str] = &["the columns of {a} and {b} are swapped (position, velocity and torque)"];
const FILTERED: &[&str] = &["the velocity of", "the columns lag"];
const NORMALISED: &[&str] = &["-100", "normalis", "per cent of the range", "share of the range"];

/// All kinds. A seed selects a kind by its index, so a new kind must be added at the end.
#[rustfmt::skip]
pub const KINDS: &[Entry] = &[
    kind("zero 10 deg", Kind::Zero(10.0), ZERO, "zero", Some(10.0), SMALL),
    kind("zero 30 deg", Kind::Zero(30.0), ZERO, "zero", Some(30.0), SMALL),
    kind("zero 90 deg", Kind::Zero(90.0), ZERO, "zero", Some(90.0), SMALL),
    kind("zero 180 deg", Kind::Zero(180.0), ZERO, "zero", Some(180.0), SMALL),
    kind("motion sign", Kind::MotionSign, MOTION_SIGN, "sign", Some(1.0), SMALL),
    kind("torque sign", Kind::TorqueSign, TORQUE_SIGN, "sign", Some(1.0), SMALL),
    kind("joint reversed", Kind::Reversed, &["{a} runs the other way round"], "sign", Some(1.0), SMALL),
    kind("all torque signs", Kind::AllTorqueSigns, &["the torques of all joints have the wrong sign"], "sign", Some(1.0), GROSS),
    kind("swapped motions", Kind::SwappedMotions, MOTIONS, "log", None, GROSS),
    kind("swapped torques", Kind::SwappedTorques, &["the torque columns of {a} and {b} are swapped"], "log", None, GROSS),
    kind("swapped columns", Kind::SwappedColumns, COLUMNS, "log", None, GROSS),
    kind("columns rotated", Kind::Rotated, ROTATED, "log", None, GROSS),
    kind("swapped velocities", Kind::SwappedVelocities, VELOCITIES, "log", None, GROSS),
    kind("degrees", Kind::Degrees, &["in degrees, taken for radians"], "log", None, GROSS),
    kind("torques in N mm", Kind::AllScaled(1e3), &["in another unit: 10^3"], "common scale", Some(1e3), GROSS),
    kind("all torques x2", Kind::AllScaled(2.0), FACTOR, "common scale", Some(2.0), SMALL),
    kind("torque x0.25", Kind::Scaled(0.25), SCALE, "scale", Some(75.0), SMALL),
    kind("torque x0.5", Kind::Scaled(0.5), SCALE, "scale", Some(50.0), SMALL),
    kind("torque x2", Kind::Scaled(2.0), SCALE, "scale", Some(100.0), SMALL),
    kind("torque x4", Kind::Scaled(4.0), SCALE, "scale", Some(300.0), SMALL),
    kind("torques x0.5, x3", Kind::TwoScaled, TWO_SCALES, "scale", Some(50.0), SMALL),
    kind("currents", Kind::Currents, CURRENTS, "common scale", None, GROSS),
    kind("late 6 ms", Kind::Late(6.0), LATE, "delay", Some(6.0), SMALL),
    kind("late 20 ms", Kind::Late(20.0), LATE, "delay", Some(20.0), GROSS),
    kind("late 60 ms", Kind::Late(60.0), LATE, "delay", Some(60.0), GROSS),
    kind("on the ceiling", Kind::Base([PI, 0.0, 0.0]), MOUNT, "mount", Some(180.0), GROSS),
    kind("on a wall", Kind::Base([0.0, FRAC_PI_2, 0.0]), MOUNT, "mount", Some(90.0), GROSS),
    kind("tilted 10 deg", Kind::Base([PI / 18.0, 0.0, 0.0]), MOUNT, "mount", Some(10.0), SMALL),
    kind("gravity taken out", Kind::GravityOut, &["gravity is not in the torques"], "mount", None, GROSS),
    kind("spring", Kind::Spring, &["acts on {a}"], "spring", None, SMALL),
    kind("load", Kind::Payload, &["load", "another tool", "other bodies", "not of this robot"], "load", None, SMALL),
    kind("other robot", Kind::OtherRobot, &["not of this robot"], "log", None, GROSS),
    kind("dead torque", Kind::DeadTorque, &["the torque of {a} is not measured"], "log", None, GROSS),
    kind("saturated", Kind::Saturated, &["the torque of {a} stands at its limit"], "log", None, GROSS),
    kind("velocities at 3 Hz", Kind::FilteredVelocities(3.0), FILTERED, "velocity column", Some(53.0), SMALL),
    kind("positions -100..100", Kind::Normalised, NORMALISED, "log", None, GROSS),
    kind("contact", Kind::Contact, &["contact", "external", "pushes"], "residual", None, SMALL),
    kind("load picked up", Kind::LoadPickedUp, LOAD, "load", None, SMALL),
    kind("drift 25 %", Kind::Drift, &["the torque of {a} grows by"], "drift", Some(25.0), SMALL),
    kind("computed torques", Kind::Computed, &["computed from this description"], "log", None, GROSS),
];
