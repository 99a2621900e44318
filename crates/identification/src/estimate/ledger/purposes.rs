//! What each use of an estimate needs.
//!
//! Every use needs another motion predicted, and nothing said against log, residual and parameters. Its torque must be
//! sure to `SURE_TORQUE` where the covariance is known. Signs, scales, zeros, mount and springs must not be
//! contradicted; where they cannot be told they lower nothing, since the torques of the log are predicted all the same.
//! Bodies need what can exist and what the description does not contradict.

use claims::{Claim, Figure, Need, Outcome, Purpose, Subject, Topic};

use crate::estimate::digits::percent;
use crate::estimate::ledger::topics::cannot_tell;
use crate::estimate::ledger::topics::*;
use crate::estimate::ledger::torque_error::{TorqueError, Use};

/// Error of predicted torque by the covariance, relative, up to which it is sure.
pub(crate) const SURE_TORQUE: f64 = 0.05;

/// The name of the use of bodies.
pub(crate) const SIMULATOR: &str = "bodies for a simulator";

fn topic(of: Use) -> Topic {
    match of {
        Use::Gravity => GRAVITY_TORQUE,
        Use::SpeedsSeen => TORQUE_SEEN,
        Use::SpeedLimits => TORQUE_AT_LIMITS,
    }
}

/// What a use of predicted torques needs.
pub(crate) fn torque_purpose(of: Use) -> Purpose {
    let purpose = common(of.name()).and(Need::where_told(Subject::whole(topic(of))));
    match of {
        Use::Gravity => purpose,
        Use::SpeedsSeen | Use::SpeedLimits => {
            let dynamic = purpose.and(Need::where_told(Subject::whole(DELAY)));
            dynamic.and(Need::where_told(Subject::whole(FRICTION)))
        }
    }
}

/// What bodies need.
pub(crate) fn bodies_purpose() -> Purpose {
    common(SIMULATOR).and(Need::where_told(Subject::whole(BODIES)))
}

fn common(name: &'static str) -> Purpose {
    let told = [LOG, RESIDUAL, PARAMETERS].map(|t| Need::where_told(Subject::whole(t)));
    let uncontradicted =
        [SIGN, COMMON_SCALE, SCALE, ZERO, MOUNT, SPRING].map(|t| Need::uncontradicted(Subject::whole(t)));
    let purpose = Purpose::new(name, Need::new(Subject::whole(OTHER_MOTION)));
    told.into_iter().chain(uncontradicted).fold(purpose, Purpose::and)
}

/// The claim on the torque of one use.
pub(crate) fn claim_of_torque(error: &TorqueError) -> Claim {
    let subject = Subject::whole(topic(error.of));
    if error.relative <= SURE_TORQUE {
        return Claim::new(subject, Outcome::Agrees { smallest: Figure::new(100.0 * error.relative, "%") });
    }
    let worst = error.worst().map_or(String::new(), |(name, share)| format!(", that of {name} by {}", percent(share)));
    let why = format!("for {} the torque is unsure by {}{worst}", error.of.name(), percent(error.relative));
    let would_tell = match error.of {
        Use::Gravity => "a motion through more of the robot's range (rist excite)",
        Use::SpeedsSeen => "a longer log, or one of a richer motion (rist excite)",
        Use::SpeedLimits => "a faster motion (rist excite)",
    };
    cannot_tell(subject, why, would_tell)
}
