//! Topics of claims. In a report, the name of a topic is followed by the joints, as in "of q2".

use claims::{Claim, Figure, Outcome, Remedy, Subject, Topic, Trial};

/// A fault of a log that makes every estimate from it unusable.
pub const LOG: Topic = Topic("log");
/// Signs of torque and motion of a joint.
pub(crate) const SIGN: Topic = Topic("sign");
/// Ratio of measured to nominal torque: one factor for all joints.
pub const COMMON_SCALE: Topic = Topic("common scale of the torques");
/// Scale of the torque of one joint relative to the other joints.
pub const SCALE: Topic = Topic("scale relative to the other joints");
/// Zero position of a joint.
pub const ZERO: Topic = Topic("zero");
/// Orientation of the base relative to gravity.
pub const MOUNT: Topic = Topic("mount");
/// A spring at a joint.
pub const SPRING: Topic = Topic("spring");
/// The inertia of the rotor behind a joint.
pub const ROTOR: Topic = Topic("rotor inertia");
/// Drift: the torque grows during a log.
pub const DRIFT: Topic = Topic("drift of the torque");
/// Delay of the torques relative to the positions.
pub(crate) const DELAY: Topic = Topic("delay");
/// Order of the columns, if it assigns the columns to the joints.
pub(crate) const ORDER: Topic = Topic("order of the columns");
/// A load that the description does not contain.
pub(crate) const LOAD: Topic = Topic("load");
/// Agreement of the velocity column with the positions.
pub(crate) const VELOCITY: Topic = Topic("velocity column");
/// Agreement of the acceleration column with the velocities.
pub(crate) const ACCELERATION: Topic = Topic("acceleration column");
/// Sign of the identified friction of a joint.
pub const FRICTION: Topic = Topic("friction");
/// The residual of the fit.
pub const RESIDUAL: Topic = Topic("residual");
/// Whether the data determine the parameters.
pub const PARAMETERS: Topic = Topic("parameters");
/// Prediction of motion that was not fitted.
pub(crate) const OTHER_MOTION: Topic = Topic("another motion");
/// Error of the predicted torque for gravity compensation.
pub(crate) const GRAVITY_TORQUE: Topic = Topic("torque at rest");
/// Error of the predicted torque for feedforward, at the speeds of the logs.
pub(crate) const TORQUE_SEEN: Topic = Topic("torque at the speeds seen");
/// Error of the predicted torque for feedforward, at the speed limits.
pub(crate) const TORQUE_AT_LIMITS: Topic = Topic("torque at the speed limits");
/// The identified bodies, for a simulator.
pub const BODIES: Topic = Topic("bodies");

/// Rotor inertias that the description does not mention and `identify` added.
pub const ROTORS_TAKEN: Topic = Topic("rotor inertias taken");
/// A delay of the torques that `identify` compensated.
pub const DELAY_TAKEN: Topic = Topic("delay taken back");
/// An orientation of the base that differs from the description and that `identify` used.
pub const MOUNT_TAKEN: Topic = Topic("mount taken");
/// Physically consistent bodies that `identify` used because the logs are poor.
pub const BODIES_TAKEN: Topic = Topic("bodies that can exist taken");

/// The claim that a topic was corrected by default. `what`: a text with the errors without and with the correction.
pub fn mended(topic: Topic, what: &str) -> Claim {
    Claim::new(Subject::whole(topic), Outcome::Assumed { what: what.into(), by: "default".into() })
}

/// The claim that something cannot be determined. `why`: the reason; `would_tell`: data that would determine it.
pub fn cannot_tell(subject: Subject, why: impl Into<String>, would_tell: impl Into<String>) -> Claim {
    Claim::new(subject, Outcome::CannotTell { why: why.into(), would_tell: would_tell.into() })
}

/// The claim that data and description agree. `value`, in `unit`: the smallest fault that would have been detected.
pub(crate) fn agrees(subject: Subject, value: f64, unit: &'static str) -> Claim {
    Claim::new(subject, Outcome::Agrees { smallest: Figure::new(value, unit) })
}

/// The claim that something is wrong, with a remedy. `why`: the reason why the remedy was not tried.
pub(crate) fn contradicted(subject: Subject, fault: String, remedy: Remedy, why: &str) -> Claim {
    Claim::new(subject, Outcome::Contradicted { fault, remedy, trial: Trial::NotTried { why: why.into() } })
}

/// The subject of a claim: a topic at the coordinates with these names.
pub(crate) fn at<'a>(topic: Topic, names: impl IntoIterator<Item = &'a String>) -> Subject {
    Subject::of(topic, names.into_iter().cloned())
}
