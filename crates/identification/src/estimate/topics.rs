//! Topics of claims (statements with their evidence): the aspect of a log or an estimate about which a claim is made. A report
//! writes the joints after the topic: `zero of q2`.

use claims::{Claim, Figure, Outcome, Remedy, Subject, Topic, Trial};

/// The log as a whole. The claim is about a fault that makes every estimate from this log unusable.
pub const LOG: Topic = Topic("log");
/// Signs of the torque and the motion of a joint.
pub(crate) const SIGN: Topic = Topic("sign");
/// A factor between measured and nominal torques that is equal for all joints.
pub const COMMON_SCALE: Topic = Topic("common scale of the torques");
/// Scale of the measured torque of one joint, relative to the scales of the other joints.
pub const SCALE: Topic = Topic("scale relative to the other joints");
/// Zero of the position of a joint.
pub const ZERO: Topic = Topic("zero");
/// Orientation of the base relative to gravity.
pub const MOUNT: Topic = Topic("mount");
/// A spring at a joint.
pub const SPRING: Topic = Topic("spring");
/// Inertia of the motor rotor of a joint.
pub const ROTOR: Topic = Topic("rotor inertia");
/// A part of the current of a joint that gives no torque.
pub const DEAD_CURRENT: Topic = Topic("dead current");
/// A gap between the encoder and the link of a joint.
pub const PLAY: Topic = Topic("play");
/// Drift of the torque of a joint: it grows from the start to the end of a log.
pub const DRIFT: Topic = Topic("drift of the torque");
/// Delay of the torques relative to the positions.
pub(crate) const DELAY: Topic = Topic("delay");
/// Order of the columns, if columns are assigned to joints by their place and not by their names.
pub(crate) const ORDER: Topic = Topic("order of the columns");
/// A load on a link that the robot description does not contain.
pub(crate) const LOAD: Topic = Topic("load");
/// Agreement of the velocity column with the derivative of the positions.
pub(crate) const VELOCITY: Topic = Topic("velocity column");
/// Agreement of the acceleration column with the derivative of the velocities.
pub(crate) const ACCELERATION: Topic = Topic("acceleration column");
/// Sign of the identified friction of a joint.
pub const FRICTION: Topic = Topic("friction");
/// The residual of the fit.
pub const RESIDUAL: Topic = Topic("residual");
/// Whether the data determine the parameters.
pub const PARAMETERS: Topic = Topic("parameters");
/// Prediction of motion that was not fitted.
pub(crate) const OTHER_MOTION: Topic = Topic("another motion");
/// Error of the predicted torque at rest, for gravity compensation.
pub(crate) const GRAVITY_TORQUE: Topic = Topic("torque at rest");
/// Error of the predicted torque at the speeds of the logs, for feedforward.
pub(crate) const TORQUE_SEEN: Topic = Topic("torque at the speeds seen");
/// Error of the predicted torque at the speed limits of the robot, for feedforward.
pub(crate) const TORQUE_AT_LIMITS: Topic = Topic("torque at the speed limits");
/// The identified bodies, for use in a simulator.
pub const BODIES: Topic = Topic("bodies");

/// Rotor inertias that the robot description does not contain and that `identify` added.
pub const ROTORS_TAKEN: Topic = Topic("rotor inertias taken");
/// A delay of the torques that `identify` compensated.
pub const DELAY_TAKEN: Topic = Topic("delay taken back");
/// Dead currents (parts of currents that give no torque) that `identify` subtracted from the currents.
pub const DEAD_CURRENT_TAKEN: Topic = Topic("dead current taken off");
/// An orientation of the base that `identify` used instead of the described one.
pub const MOUNT_TAKEN: Topic = Topic("mount taken");
/// Physically consistent bodies that `identify` used because the logs determine too little.
pub const BODIES_TAKEN: Topic = Topic("bodies that can exist taken");

/// The claim that a fault was corrected by default. `topic`: the aspect that was corrected; `what`: a text with the errors
/// without and with the correction.
pub fn mended(topic: Topic, what: &str) -> Claim {
    Claim::new(Subject::whole(topic), Outcome::Assumed { what: what.into(), by: "default".into() })
}

/// The claim that something cannot be determined. `why`: the reason; `would_tell`: data that would determine it.
pub fn cannot_tell(subject: Subject, why: impl Into<String>, would_tell: impl Into<String>) -> Claim {
    Claim::new(subject, Outcome::CannotTell { why: why.into(), would_tell: would_tell.into() })
}

/// The claim that the data agree with the description. `value`, in `unit`: the smallest fault that the data would have shown.
pub(crate) fn agrees(subject: Subject, value: f64, unit: &'static str) -> Claim {
    Claim::new(subject, Outcome::Agrees { smallest: Figure::new(value, unit) })
}

/// The claim that the data contradict the description. `fault`: the fault as a clause; `why`: the reason why the remedy was
/// not tried.
pub(crate) fn contradicted(subject: Subject, fault: String, remedy: Remedy, why: &str) -> Claim {
    Claim::new(subject, Outcome::Contradicted { fault, remedy, trial: Trial::NotTried { why: why.into() } })
}

/// Makes the subject of a claim: a topic and the names of the coordinates.
pub(crate) fn at<'a>(topic: Topic, names: impl IntoIterator<Item = &'a String>) -> Subject {
    Subject::of(topic, names.into_iter().cloned())
}
