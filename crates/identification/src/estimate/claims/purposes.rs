//! Defines which claims each use of an estimate needs.
//!
//! Every use needs a good prediction of another motion, and no claim against the log, the residual or the parameters. Signs,
//! scales, zeros, mount (orientation of the base) and springs must not be contradicted. A sign, scale, zero, mount or spring
//! that cannot be determined does not lower the trust, because the torques of the log are predicted equally well whether it is
//! right or wrong.
//!
//! With a covariance, the relative torque error of the use must be below `SURE_TORQUE`, and the torque error of each joint
//! below `SURE_JOINT_TORQUE_ERROR`. A use is refused if its error exceeds `USELESS_TORQUE_ERROR`, or if it needs undetermined
//! parameters. Bodies (inertial parameters of the links) can be used only if they are physically consistent and do not
//! contradict the description.

use claims::{Claim, EvidenceLevel, Need, Purpose, Remedy, Subject, Topic};

use crate::estimate::artefact::Estimate;
use crate::estimate::digits::percent;
use crate::estimate::identified::Status;
use crate::estimate::residuals::JointResidual;
use crate::estimate::topics::*;
use crate::estimate::torque_error::{JointTorqueError, SURE_TORQUE, TorqueError, Use};

/// A use is refused if the relative error of its predicted torques, from the covariance, exceeds this value.
const USELESS_TORQUE_ERROR: f64 = 0.5;
/// Largest accepted torque error of one joint, relative to the joint's torque in this use or in the logs; the larger of the two
/// torques is taken. Errors below the rms residual of the joint are always accepted. This limit is larger than the limit for
/// the whole robot (`SURE_TORQUE`), because joints with small torques have larger relative errors.
const SURE_JOINT_TORQUE_ERROR: f64 = 0.1;

/// Name of the use of identified bodies, in reports.
pub(crate) const SIMULATOR: &str = "bodies for a simulator";

fn topic(of: Use) -> Topic {
    match of {
        Use::Gravity => GRAVITY_TORQUE,
        Use::SpeedsSeen => TORQUE_SEEN,
        Use::SpeedLimits => TORQUE_AT_LIMITS,
    }
}

/// The claims that a use of predicted torques needs.
pub(crate) fn torque_purpose(of: Use) -> Purpose {
    let purpose = common(of.name()).and(Need::where_claimed(Subject::whole(topic(of))));
    match of {
        Use::Gravity => purpose,
        Use::SpeedsSeen | Use::SpeedLimits => {
            let dynamic = purpose.and(Need::where_claimed(Subject::whole(DELAY)));
            dynamic.and(Need::where_claimed(Subject::whole(FRICTION)))
        }
    }
}

/// The claims that the use of bodies in a simulator needs.
pub(crate) fn bodies_purpose() -> Purpose {
    common(SIMULATOR).and(Need::where_claimed(Subject::whole(BODIES)))
}

fn common(name: &'static str) -> Purpose {
    let claimed = [LOG, RESIDUAL, PARAMETERS].map(|t| Need::where_claimed(Subject::whole(t)));
    let uncontradicted =
        [SIGN, COMMON_SCALE, SCALE, ZERO, MOUNT, SPRING].map(|t| Need::uncontradicted(Subject::whole(t)));
    let purpose = Purpose::new(name, Need::new(Subject::whole(OTHER_MOTION)));
    claimed.into_iter().chain(uncontradicted).fold(purpose, Purpose::and)
}

/// The claim on the torque error in one use. `joints`: residuals of the fit, one per coordinate.
pub(crate) fn claim_of_torque(error: &TorqueError, joints: &[JointResidual]) -> Claim {
    let subject = Subject::whole(topic(error.of));
    // A joint may have little torque in this use. Then the torque error of the joint is compared with the joint's torque in the
    // logs.
    let is_hidden = |(j, left): (&JointTorqueError, &JointResidual)| {
        let logged = if left.relative > 0.0 { left.rms / left.relative } else { 0.0 };
        j.error > SURE_JOINT_TORQUE_ERROR * j.torque.max(logged) && j.error > left.rms
    };
    let is_sure = error.relative <= SURE_TORQUE;
    if is_sure && !error.joints.iter().zip(joints).any(is_hidden) {
        return agrees(subject, 100.0 * error.relative, "%");
    }
    let worst = error.worst().map_or(String::new(), |(name, share)| format!(", at {name} {}", percent(share)));
    let near = error.within_seen.filter(|near| near.is_finite());
    let near = near.map_or(String::new(), |near| format!("; within the positions of the log {}", percent(near)));
    let why = match error.relative.is_finite() {
        true => format!("for {} the torque uncertainty is {}{worst}{near}", error.of.name(), percent(error.relative)),
        false => undetermined_sentence(error.of, &error.undetermined_joints()),
    };
    let would_tell = match error.of {
        Use::Gravity => "a motion through more of the robot's range ([:excite])",
        Use::SpeedsSeen => "a longer log, or one of a richer motion ([:excite])",
        Use::SpeedLimits => "a faster motion ([:excite])",
    };
    if error.relative <= USELESS_TORQUE_ERROR {
        return cannot_tell(subject, why, would_tell);
    }
    refused(subject, why, would_tell)
}

fn refused(subject: Subject, fault: String, would_tell: &str) -> Claim {
    contradicted(subject, fault, Remedy::new("excite", would_tell), "it needs another log")
}

fn undetermined_sentence(of: Use, joints: &[&str]) -> String {
    format!(
        "for {} the torque of {} is not determined: the log does not identify all of its parameters",
        of.name(),
        joints.join(", ")
    )
}

/// Claims that no torque is determined, one claim per use. These claims are made if a joint stood still in all logs and
/// parameters are undetermined; otherwise the list is empty.
pub(crate) fn undetermined_torques(estimate: &Estimate) -> Vec<Claim> {
    let still = standing(&estimate.joints);
    let is_open = estimate.parameters.iter().any(|p| p.status == Status::NotIdentifiable);
    let one = |of: Use| {
        let fault = format!("for {} no torque is determined: {} never moved", of.name(), still.join(", "));
        refused(Subject::whole(topic(of)), fault, "a motion of all joints ([:excite])")
    };
    if still.is_empty() || !is_open { Vec::new() } else { Use::ALL.map(one).to_vec() }
}

/// Names of the joints that never moved. Such joints have no rows and no bandwidth `f95` (95 % of the velocity's energy is
/// below f95).
pub(crate) fn standing(joints: &[JointResidual]) -> Vec<&str> {
    joints
        .iter()
        .filter(|joint| joint.rows == 0 && joint.f95.is_none())
        .map(|joint| joint.coordinate.as_str())
        .collect()
}

/// Splits a claim of agreement. For joints that never moved, the claim becomes "cannot tell", because only one position was
/// measured. A claim on the mount becomes "cannot tell" if any joint never moved. `still`: names of the joints that never moved.
pub(crate) fn where_it_stands(claim: Claim, still: &[&str]) -> Vec<Claim> {
    let subject = claim.subject();
    let [stands, moves]: [Vec<&String>; 2] = [true, false].map(|stands| {
        subject.of.iter().filter(|name| stands == (subject.topic == MOUNT || still.contains(&name.as_str()))).collect()
    });
    if still.is_empty() || stands.is_empty() || claim.standing() < EvidenceLevel::Agreed {
        return vec![claim];
    }
    let why = format!("{} never moved", still.join(", "));
    let open = cannot_tell(at(subject.topic, stands), why, "a motion of all joints ([:excite])");
    let kept = (!moves.is_empty()).then(|| Claim::new(at(subject.topic, moves), claim.outcome().clone()));
    kept.into_iter().chain([open]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::residuals::{Residuals, Squares};
    use crate::test_arm::Pendulum;
    use claims::{Figure, Outcome};

    fn joint(rms: f64) -> Vec<JointResidual> {
        let squares = Squares { torque: 0.25, residual: rms * rms, rows: 1 };
        Residuals::new(&Pendulum::new(), vec![squares]).joints
    }

    #[test]
    fn the_sum_hides_no_joint_and_what_is_half_wrong_serves_nothing() {
        let of = |relative: f64, error: f64, rms: f64| {
            let joints = vec![JointTorqueError { coordinate: "q1".into(), error, torque: 1.0 }];
            claim_of_torque(&TorqueError { of: Use::Gravity, joints, relative, within_seen: None }, &joint(rms))
                .standing()
        };
        assert_eq!(of(0.04, 0.09, 0.01), EvidenceLevel::Agreed);
        assert_eq!((of(0.04, 0.11, 0.01), of(0.04, 0.11, 0.2)), (EvidenceLevel::Open, EvidenceLevel::Agreed));
        assert_eq!((of(0.49, 0.49, 0.01), of(0.51, 0.51, 0.01)), (EvidenceLevel::Open, EvidenceLevel::Refused));
        assert_eq!(of(f64::INFINITY, f64::INFINITY, 0.01), EvidenceLevel::Refused);
    }

    #[test]
    fn nothing_agrees_with_a_joint_that_never_moved() {
        let agrees = |topic: Topic, names: &[&str]| {
            let smallest = Figure::new(1.0, "deg");
            Claim::new(Subject::of(topic, names.iter().copied()), Outcome::Agrees { smallest })
        };
        let of = |claim: Claim, still: &[&str]| {
            where_it_stands(claim, still).iter().map(ToString::to_string).collect::<Vec<_>>().join("; ")
        };
        let both = agrees(ZERO, &["q1", "q2"]);
        assert_eq!(of(both.clone(), &[]), both.to_string());
        let (parted, of_q1) = (of(both, &["q2"]), agrees(ZERO, &["q1"]).to_string());
        assert!(parted.starts_with(&of_q1) && parted.contains("q2 never moved"), "{parted}");
        assert!(of(agrees(MOUNT, &["x", "y"]), &["q2"]).contains("q2 never moved"));
        let moving = agrees(SPRING, &["q1"]);
        assert_eq!(of(moving.clone(), &["q2"]), moving.to_string());
    }
}
