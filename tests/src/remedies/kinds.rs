//! The kinds of mistake: a line each in [`KINDS`].

use std::f64::consts::{FRAC_PI_2, PI};

/// What is done to a log, or to the machine while it is logged. A joint is drawn for those that have one, and two for
/// those of a pair.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    /// The zero of a joint is off, degrees.
    Zero(f64),
    /// Position and velocity of a joint have the other sign.
    MotionSign,
    /// The torque of a joint has the other sign.
    TorqueSign,
    /// Both have.
    Reversed,
    /// The torques of all joints have.
    AllTorqueSigns,
    /// Positions and velocities of two joints are exchanged.
    SwappedMotions,
    /// Only the velocities are.
    SwappedVelocities,
    /// Only the torques are.
    SwappedTorques,
    /// All are.
    SwappedColumns,
    /// All columns of a joint stand under the name of the next.
    Rotated,
    /// All angles and their rates are in degrees.
    Degrees,
    /// All torques are so many times too large.
    AllScaled(f64),
    /// The torque of a joint is so many times too large.
    Scaled(f64),
    /// The torque of a joint is half, that of another three times what it should be.
    TwoScaled,
    /// The torques are currents of unlike gains.
    Currents,
    /// The torques are late by so many ms.
    Late(f64),
    /// The base is turned by roll, pitch and yaw, rad.
    Base([f64; 3]),
    /// The torque that holds the bodies is taken out.
    GravityOut,
    /// A spring takes a half of a joint's usual torque at the end of its motion.
    Spring,
    /// The last link carries a load.
    Payload,
    /// The last link carries a load from half time on.
    LoadPickedUp,
    /// Another robot with as many joints.
    OtherRobot,
    /// A torque that never changes.
    DeadTorque,
    /// A torque that ends at 60 % of its largest.
    Saturated,
    /// The velocities are filtered, first order with this cut-off, Hz.
    FilteredVelocities(f64),
    /// Positions in -100..100 of the range of each joint.
    Normalised,
    /// For 1 s something pushes against a joint with 30 % of its usual torque.
    Contact,
    /// The torque of a joint grows by a quarter from the first sample to the last.
    Drift,
    /// The torques are those of the description.
    Computed,
}

impl Kind {
    /// Whether the motors give the torques that are logged, as the machine is, at the instants of the log.
    pub fn is_of_machine(self) -> bool {
        matches!(
            self,
            Kind::Base(_) | Kind::Spring | Kind::Payload | Kind::LoadPickedUp | Kind::Contact | Kind::OtherRobot
        )
    }
}

/// A mistake, and the joints that have it.
#[derive(Clone, Copy, Debug)]
pub struct Mistake {
    /// What is done.
    pub kind: Kind,
    /// The joint that has it, or the first of two.
    pub a: usize,
    /// The second of two.
    pub b: usize,
    /// A number of [0, 1) for what else is drawn.
    pub more: f64,
}

/// A kind, and how it is known again in what the program prints.
pub struct Entry {
    /// What it is called.
    pub name: &'static str,
    /// What is done.
    pub kind: Kind,
    /// Words of a finding that names it; one of them is enough. `{a}` and `{b}` are its joints.
    pub right: &'static [&'static str],
    /// The first word of the claims about it (`agrees: zero of j2; 20 deg would have shown`).
    pub topic: &'static str,
    /// How large it is in the unit of such a claim, where that does not follow from the machine.
    pub size: Option<f64>,
    /// Whether it should show although the program prints no least size of its kind.
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

/// All kinds. A seed takes one by its place, so a new one stands at the end.
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
