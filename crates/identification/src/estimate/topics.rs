//! What is claimed about; each stands before "of q2".

use claims::{Claim, Figure, Outcome, Remedy, Subject, Topic, Trial};

/// Anything about a log that no estimate from it survives.
pub const LOG: Topic = Topic("log");
/// Which way torque and motion count.
pub(crate) const SIGN: Topic = Topic("sign");
/// Torque per torque of the description, of all joints alike.
pub const COMMON_SCALE: Topic = Topic("common scale of the torques");
/// Torque of a joint beside that of the others.
pub const SCALE: Topic = Topic("scale beside the other joints");
/// Where a joint is at zero.
pub const ZERO: Topic = Topic("zero");
/// How the base is mounted under gravity.
pub const MOUNT: Topic = Topic("mount");
/// A spring at a joint.
pub const SPRING: Topic = Topic("spring");
/// The inertia of the rotor behind a joint.
pub const ROTOR: Topic = Topic("rotor inertia");
/// Torque that grows while a log is made.
pub const DRIFT: Topic = Topic("drift of the torque");
/// By how much torques lag positions.
pub(crate) const DELAY: Topic = Topic("delay");
/// Whose columns are whose, where their place says it.
pub(crate) const ORDER: Topic = Topic("order of the columns");
/// A load that the description does not have.
pub(crate) const LOAD: Topic = Topic("load");
/// The column of velocities.
pub(crate) const VELOCITY: Topic = Topic("velocity column");
/// The column of accelerations.
pub(crate) const ACCELERATION: Topic = Topic("acceleration column");
/// Friction.
pub const FRICTION: Topic = Topic("friction");
/// What the fit leaves.
pub const RESIDUAL: Topic = Topic("residual");
/// Whether parameters are determined.
pub const PARAMETERS: Topic = Topic("parameters");
/// Motion that was not fitted.
pub(crate) const OTHER_MOTION: Topic = Topic("another motion");
/// Torque for gravity compensation.
pub(crate) const GRAVITY_TORQUE: Topic = Topic("torque at rest");
/// Torque for feedforward at the speeds seen.
pub(crate) const TORQUE_SEEN: Topic = Topic("torque at the speeds seen");
/// Torque for feedforward at the speed limits.
pub(crate) const TORQUE_AT_LIMITS: Topic = Topic("torque at the speed limits");
/// The bodies for a simulator.
pub const BODIES: Topic = Topic("bodies");

/// Rotors of which the description did not speak: identify took them by itself.
pub const ROTORS_TAKEN: Topic = Topic("rotor inertias taken");
/// The torques that came later than the positions.
pub const DELAY_TAKEN: Topic = Topic("delay taken back");
/// A base that is mounted otherwise than described.
pub const MOUNT_TAKEN: Topic = Topic("mount taken");
/// Bodies that can exist, where the logs are poor.
pub const BODIES_TAKEN: Topic = Topic("bodies that can exist taken");

/// What was mended without being asked for; `what` has the errors without it and with it.
pub fn mended(topic: Topic, what: &str) -> Claim {
    Claim::new(Subject::whole(topic), Outcome::Assumed { what: what.into(), by: "default".into() })
}

/// That something cannot be told.
pub fn cannot_tell(subject: Subject, why: impl Into<String>, would_tell: impl Into<String>) -> Claim {
    Claim::new(subject, Outcome::CannotTell { why: why.into(), would_tell: would_tell.into() })
}

/// That something is as it should be, where a fault of so much would have shown.
pub(crate) fn agrees(subject: Subject, value: f64, unit: &'static str) -> Claim {
    Claim::new(subject, Outcome::Agrees { smallest: Figure::new(value, unit) })
}

/// That something is wrong, with what mends it and why that was not tried.
pub(crate) fn contradicted(subject: Subject, fault: String, remedy: Remedy, why: &str) -> Claim {
    Claim::new(subject, Outcome::Contradicted { fault, remedy, trial: Trial::NotTried { why: why.into() } })
}

/// A topic at coordinates.
pub(crate) fn at<'a>(topic: Topic, names: impl IntoIterator<Item = &'a String>) -> Subject {
    Subject::of(topic, names.into_iter().cloned())
}
