//! What a fit leaves open, and what it predicts, as claims.

use claims::{Claim, Figure, Outcome, Remedy, Subject, Trial};
use linear_model::label::Label;
use linear_model::parameter::{FrictionParameter, ParameterId};

use crate::estimate::artefact::Estimate;
use crate::estimate::autocorrelation::NOISE_MEMORY_PERIODS;
use crate::estimate::digits::{percent, significant};
use crate::estimate::identified::{Identified, Status};
use crate::estimate::ledger::topics::{BODIES, FRICTION, LOG, OTHER_MOTION, PARAMETERS, RESIDUAL, cannot_tell};
use crate::estimate::residuals::JointResidual;

/// Chi^2 per degree of freedom above which the model lacks something. Simulations whose model is right have 1.5 to 2.0,
/// because what a controller does on its encoder repeats in part from period to period. A ripple of 2 % gives 22, joints
/// that bend at 25 Hz give 1190, and torques that are 1.5 ms late give 147 (`tests/benches/misfit.rs`).
pub(crate) const LACKING_MODEL_CHI_SQUARE: f64 = 4.0;
/// Up to this noise explains all.
pub(crate) const NOISE_CHI_SQUARE: f64 = 2.0;

/// Error on another motion up to which an estimate predicts well.
const GOOD_PREDICTION_ERROR: f64 = 0.05;
/// The same where what is left is noise, which no parameter can predict.
const GOOD_NOISY_PREDICTION_ERROR: f64 = 0.2;
/// Error on data that were not fitted above which parameters predict nothing.
const USELESS_PREDICTION_ERROR: f64 = 0.5;
/// Error of an estimate over that of the description on another motion, above which the description is the better one; noise
/// moves the ratio by some hundredths.
const WORSE_ERROR_RATIO: f64 = 1.05;
/// The same above which the estimate is wrong.
const FAR_WORSE_ERROR_RATIO: f64 = 2.0;
/// What the deviations of the parameters explain of an error is up to so many times their root mean square.
const EXPLAINED_DEVIATIONS: f64 = 2.0;
/// Share of the torque that may stay unexplained.
const LARGE_RESIDUAL: f64 = 0.25;

/// Error on data that were not fitted over that of the fit above which the fit holds for its own log only.
const OVERFITTED_ERROR_RATIO: f64 = 2.0;
/// Errors on data that were not fitted below this are small enough, even where the description predicts better.
const SMALL_HELD_OUT_ERROR: f64 = 0.02;

/// Scaled condition number above which errors of the model decide the weakest direction. Estimates of the bench
/// `random_situations` that are right have up to 2831.
const DECIDING_CONDITION_NUMBER: f64 = 3000.0;

/// A residual whose memory is more than this many times that of noise is none.
const LONG_MEMORY_RATIO: f64 = 2.0;

/// Friction that is negative by so many deviations drives.
const DRIVING_SIGMAS: f64 = 3.0;

/// How well motion was predicted that was not fitted.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Prediction {
    /// Error on other logs.
    pub others: Option<f64>,
    /// Whether those repeat the motion that was fitted.
    pub others_repeat: bool,
    /// Error of the description on those logs, friction fitted.
    pub others_described: Option<f64>,
    /// Error on those logs that the deviations of the parameters explain, where the covariance is known.
    pub others_unsure: Option<f64>,
    /// What of the error p on other logs is that of the parameters: sqrt(p^2 - f^2), with f the error that the model leaves of
    /// such a log where it is fitted to that log alone: noise, and what the model lacks. The largest of all logs.
    pub others_by_parameters: Option<f64>,
    /// Error on parts of the fitted logs, each predicted from the others.
    pub held_out: Option<f64>,
    /// Whether each such part is a motion that the others do not repeat.
    pub parts_are_new: bool,
}

/// What is known of the torques beside the fit.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Beside {
    /// Whether what the log leaves open is open in every motion, so that no torque shows it.
    pub opens_in_any_motion: bool,
    /// Whether the covariance says how unsure torques are: then that says what the weakest direction does to them.
    pub tells_torques: bool,
}

/// The claims of a fit, contradictions first. `total`: the error on the logs that are looked at.
pub(crate) fn claims_of_fit(
    estimate: &Estimate,
    total: Option<f64>,
    prediction: &Prediction,
    beside: Beside,
) -> Vec<Claim> {
    let mut claims = vec![other_motion(estimate, prediction)];
    claims.extend(estimate.refusal.iter().map(|why| earlier(why)));
    claims.extend(friction(estimate));
    let whole = Subject::whole;
    // What speaks against the fit as a whole: its residual, its file, its iteration.
    if let Some(chi) = estimate.chi_square_per_freedom {
        claims.push(match chi > LACKING_MODEL_CHI_SQUARE {
            true => cannot_tell(
                whole(RESIDUAL),
                format!(
                    "the model lacks something: chi^2 per freedom is {chi:.1}, where noise alone gives up to \
                     {NOISE_CHI_SQUARE}"
                ),
                "the effect that the remarks name, as an unknown",
            ),
            false => Claim::new(
                whole(RESIDUAL),
                Outcome::Agrees { smallest: Figure::new(LACKING_MODEL_CHI_SQUARE, "chi^2 per freedom") },
            ),
        });
    }
    claims.extend(estimate.doubts.iter().map(|why| cannot_tell(whole(RESIDUAL), why, "a model that has it")));
    if let Some(said) = estimate.seal.said() {
        claims.push(cannot_tell(whole(PARAMETERS), said, "the file as it was written, or a new identification"));
    }
    if estimate.settled == Some(false) {
        let why = "the method did not settle: the values still change from round to round";
        claims.push(cannot_tell(whole(RESIDUAL), why, "a richer motion"));
    }
    if let Some(total) = total.filter(|x| *x > LARGE_RESIDUAL) {
        claims.push(cannot_tell(
            whole(RESIDUAL),
            format!("{} of the torques stay unexplained", percent(total)),
            "the cause: rist doctor looks for it, [friction=auto] tries other laws",
        ));
    }
    // Which parameters the record does not decide, or decides by little motion.
    if let Some(why) = overfitted(estimate, prediction) {
        claims.push(cannot_tell(whole(PARAMETERS), why, "a longer and richer motion (rist plan)"));
    }
    claims.extend(undecided(estimate, beside));
    let is_deciding = |x: &f64| x.is_finite() && *x > DECIDING_CONDITION_NUMBER && !beside.tells_torques;
    if let Some(condition) = estimate.condition_number.filter(is_deciding) {
        let why = format!("the condition number is {condition:.0}");
        claims.push(cannot_tell(
            whole(PARAMETERS),
            why,
            "a motion that excites the weakest direction (rist excite [after])",
        ));
    }
    claims
}

/// What was found against the estimate earlier still holds.
fn earlier(why: &str) -> Claim {
    let remedy = Remedy::new("identify", "identify again with what mends it");
    let trial = Trial::NotTried { why: "the file says no more".into() };
    Claim::new(Subject::whole(LOG), Outcome::Contradicted { fault: why.into(), remedy, trial })
}

/// What the log leaves open or hardly decides.
fn undecided(estimate: &Estimate, beside: Beside) -> Vec<Claim> {
    let mut claims = Vec::new();
    let moved = "a motion of the joints that the remarks name, or bodies to hold them ([consistent=true])";
    let open = named(estimate, Status::NotIdentifiable);
    if !open.is_empty() {
        claims.push(match beside.opens_in_any_motion {
            true => cannot_tell(
                Subject::whole(BODIES),
                format!("no motion tells {open} apart: only their sum shows in a torque"),
                "bodies to hold them ([consistent=true])",
            ),
            false => cannot_tell(Subject::whole(PARAMETERS), format!("the log leaves open {open}"), moved),
        });
    }
    let weak = named(estimate, Status::Weak);
    if !weak.is_empty() {
        claims.push(cannot_tell(Subject::whole(PARAMETERS), format!("little motion decides {weak}"), moved));
    }
    claims
}

fn other_motion(estimate: &Estimate, prediction: &Prediction) -> Claim {
    let subject = Subject::whole(OTHER_MOTION);
    let would_tell = "a log of another motion (rist validate MODEL ESTIMATE LOG, or [validate])";
    // Only a motion that was not fitted counts; a bad prediction of any motion is bad all the same.
    let of_logs = prediction.others.filter(|_| !prediction.others_repeat);
    let of_parts = prediction.held_out.filter(|_| prediction.parts_are_new);
    let worst = prediction.others.into_iter().chain(prediction.held_out).fold(0.0, f64::max);
    if worst >= USELESS_PREDICTION_ERROR {
        let (what, error) = match prediction.others.filter(|e| *e >= USELESS_PREDICTION_ERROR) {
            Some(error) => ("logs that were not fitted are", error),
            None => ("parts of the log left out are", worst),
        };
        return Claim::new(
            subject,
            Outcome::Contradicted {
                fault: format!("{what} predicted with an error of {}", percent(error)),
                remedy: Remedy::new("doctor", "look what log and description have to do with each other"),
                trial: Trial::NotTried { why: "nothing is known of the cause".into() },
            },
        );
    }
    // The description is a rival: where it predicts far better, or better than noise explains, the fit holds for its own log
    // only.
    if let (Some(error), Some(described)) = (of_logs, prediction.others_described)
        && error > WORSE_ERROR_RATIO * described
        && error > SMALL_HELD_OUT_ERROR
    {
        let unsure =
            prediction.others_unsure.map_or(String::new(), |e| format!(", which are unsure by {}", percent(e)));
        let why = format!(
            "the description predicts the other log better ({}) than these parameters do ({}){unsure}",
            percent(described),
            percent(error)
        );
        let is_explained = error <= described.hypot(EXPLAINED_DEVIATIONS * prediction.others_unsure.unwrap_or(0.0));
        let is_far_worse = error > FAR_WORSE_ERROR_RATIO * described && error > GOOD_PREDICTION_ERROR;
        if is_far_worse && !is_explained {
            let remedy =
                Remedy::new("identify", "identify again from logs of this robot as it is now, or keep the description");
            let trial = Trial::NotTried { why: "nothing is known of the cause".into() };
            return Claim::new(subject, Outcome::Contradicted { fault: why, remedy, trial });
        }
        if is_far_worse || !is_explained {
            return cannot_tell(subject, why, "a longer and richer motion (rist plan)");
        }
    }
    let Some(error) = of_logs.or(of_parts) else {
        let why = match prediction.others.is_some() {
            true => "the logs that were not fitted repeat the motion of those that were",
            false => "no motion was predicted but the one that was fitted",
        };
        return Claim::new(subject, Outcome::NotLookedAt { why: why.into(), would_tell: would_tell.into() });
    };
    // Noise cannot be predicted: where what is left looks like it, more error is allowed.
    let is_noise = is_noise(estimate) && estimate.total.is_some_and(|x| error < OVERFITTED_ERROR_RATIO * x);
    // Nor can parameters be blamed for what those of that log itself leave.
    let is_least = of_logs.and(prediction.others_by_parameters).unwrap_or(error) <= GOOD_PREDICTION_ERROR;
    let most = if is_noise || is_least { GOOD_NOISY_PREDICTION_ERROR } else { GOOD_PREDICTION_ERROR };
    match error <= most {
        true => Claim::new(subject, Outcome::Agrees { smallest: Figure::new(100.0 * error, "% of the torque") }),
        false => cannot_tell(
            subject,
            format!("another motion is predicted with an error of {}", percent(error)),
            "what is missing in the model: rist doctor, [friction=auto]",
        ),
    }
}

/// Whether what is left at every joint has no longer memory than noise.
fn is_noise(estimate: &Estimate) -> bool {
    let memory = |j: &JointResidual| Some(times(estimate.cutoff?, j.memory?));
    let known: Vec<f64> = estimate.joints.iter().filter_map(memory).collect();
    !known.is_empty() && known.iter().all(|times| *times <= LONG_MEMORY_RATIO)
}

/// The memory of a residual over that of noise below the cut-off.
fn times(cutoff: f64, memory: f64) -> f64 {
    memory * cutoff / NOISE_MEMORY_PERIODS
}

/// What the autocorrelation of the residual says, for the joint with the longest memory.
pub(crate) fn not_noise(estimate: &Estimate) -> Option<String> {
    let known = estimate.joints.iter().filter_map(|joint| Some((joint, joint.memory?)));
    let (joint, memory) = known.max_by(|a, b| a.1.total_cmp(&b.1))?;
    let (name, times) = (&joint.coordinate, times(estimate.cutoff?, memory));
    Some(match times > LONG_MEMORY_RATIO {
        true => format!(
            "what is left at {name} is not noise alone: it stays alike for {} s, {times:.0} times as long as noise does, so friction or \
             flexibility is missing",
            significant(memory),
        ),
        false => "what is left looks like noise".into(),
    })
}

fn overfitted(estimate: &Estimate, prediction: &Prediction) -> Option<String> {
    let error = prediction.others_by_parameters.or(prediction.others).or(prediction.held_out)?;
    let total = estimate.total?;
    (error > GOOD_PREDICTION_ERROR && error > OVERFITTED_ERROR_RATIO * total).then(|| {
        format!(
            "data that were not fitted are predicted with {}, those that were with {}: the log is too short or too poor \
             for so many parameters",
            percent(error),
            percent(total)
        )
    })
}

/// Friction that drives, of joints with no term beyond the customary ones: beside another law each part may be negative.
fn friction(estimate: &Estimate) -> Vec<Claim> {
    let has_no_other = |joint: &Label| {
        let others = estimate.parameters.iter().filter_map(|p| match &p.id {
            ParameterId::Friction(term, label) if label == joint => Some(*term),
            _ => None,
        });
        others.into_iter().all(is_customary)
    };
    let drives = |p: &&Identified| {
        let is_brake =
            matches!(&p.id, ParameterId::Friction(friction, joint) if friction.brakes() && has_no_other(joint));
        is_brake && p.value.is_some_and(|value| value < -DRIVING_SIGMAS * p.sigma_or_infinity())
    };
    let claim = |p: &Identified| {
        let ParameterId::Friction(_, label) = &p.id else { unreachable!("only friction is looked at") };
        let subject = Subject::of(FRICTION, [label.to_string()]);
        let (value, sigma) = (p.value.unwrap_or(0.0), p.sigma_or_infinity());
        cannot_tell(
            subject,
            format!("{} is {} +- {}, and friction cannot drive", p.id, significant(value), significant(sigma)),
            "the sign, the unit and the saturation of that joint's torque, or another law of friction ([friction=auto])",
        )
    };
    estimate.parameters.iter().filter(drives).map(claim).collect()
}

/// Whether it is viscous or Coulomb friction or an offset, of both directions or of one.
fn is_customary(term: FrictionParameter) -> bool {
    use FrictionParameter::*;
    matches!(term, Viscous | Coulomb | Offset | ViscousForward | CoulombForward | ViscousBackward | CoulombBackward)
}

/// The parameters of a status, at most three by name.
fn named(estimate: &Estimate, status: Status) -> String {
    let all: Vec<String> =
        estimate.parameters.iter().filter(|p| p.status == status).map(|p| p.id.to_string()).collect();
    match all.len() {
        0..=3 => all.join(", "),
        n => format!("{} and {} more", all[..3].join(", "), n - 3),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A description that predicts better counts where the deviations of the parameters do not explain it.
    #[test]
    fn a_better_description_counts_beyond_the_deviations() {
        let of = |error: f64, described: f64, unsure: Option<f64>| {
            let prediction = Prediction {
                others: Some(error),
                others_described: Some(described),
                others_unsure: unsure,
                ..Prediction::default()
            };
            other_motion(&Estimate::default(), &prediction).outcome().clone()
        };
        let why = |outcome: Outcome| match outcome {
            Outcome::CannotTell { why, .. } => why,
            other => panic!("{other:?}"),
        };
        // sqrt(0.03^2 - 0.02^2) = 0.0224
        assert!(matches!(of(0.03, 0.02, Some(0.0113)), Outcome::Agrees { .. }));
        let beyond = "the description predicts the other log better (2.00 %) than these parameters do (3.00 %)";
        assert_eq!(why(of(0.03, 0.02, Some(0.0111))), format!("{beyond}, which are unsure by 1.11 %"));
        assert_eq!(why(of(0.03, 0.02, None)), beyond);
        assert!(matches!(of(0.0205, 0.02, None), Outcome::Agrees { .. }));
        // Much worse, and more than a use may be off: a contradiction where the deviations do not explain it.
        assert!(matches!(of(0.06, 0.02, Some(0.028)), Outcome::Contradicted { .. }));
        assert!(why(of(0.06, 0.02, Some(0.029))).ends_with("which are unsure by 2.90 %"));
        assert!(why(of(0.06, 0.04, Some(0.1))).starts_with("another motion is predicted with an error"));
    }

    /// What the parameters of another log itself leave of it is not held against those that predict it.
    #[test]
    fn the_noise_of_another_log_is_its_own() {
        let of = |error: f64, by_parameters: Option<f64>| {
            let prediction =
                Prediction { others: Some(error), others_by_parameters: by_parameters, ..Prediction::default() };
            let estimate = Estimate { total: Some(0.01), ..Estimate::default() };
            let agrees = matches!(other_motion(&estimate, &prediction).outcome(), Outcome::Agrees { .. });
            (agrees, overfitted(&estimate, &prediction).is_some())
        };
        // sqrt(0.12^2 - 0.115^2) = 0.034
        assert_eq!(of(0.12, Some(0.034)), (true, false));
        assert_eq!(of(0.12, Some(0.06)), (false, true));
        assert_eq!(of(0.12, None), (false, true));
        // A log of noise tells nothing of the parameters.
        assert_eq!(of(0.25, Some(0.034)), (false, false));
    }

    /// Where the covariance tells how unsure torques are, the condition number says no more.
    #[test]
    fn the_condition_number_counts_where_no_covariance_does() {
        let estimate = Estimate { condition_number: Some(1e4), ..Estimate::default() };
        for tells_torques in [false, true] {
            let beside = Beside { opens_in_any_motion: false, tells_torques };
            let claims = claims_of_fit(&estimate, None, &Prediction::default(), beside);
            assert_eq!(claims.iter().any(|claim| claim.subject().topic == PARAMETERS), !tells_torques);
        }
    }

    /// What no motion tells apart lowers the bodies and no torque.
    #[test]
    fn what_no_motion_tells_is_open_for_bodies_alone() {
        let open = Identified::unidentifiable("MX3".parse().unwrap(), linear_model::unit::Unit::FIRST_MOMENT, 1.0);
        let estimate = Estimate { parameters: vec![open], ..Estimate::default() };
        for in_any_motion in [false, true] {
            let beside = Beside { opens_in_any_motion: in_any_motion, tells_torques: false };
            let claims = claims_of_fit(&estimate, None, &Prediction::default(), beside);
            let about = |topic| claims.iter().filter(|claim| claim.subject().topic == topic).count();
            assert_eq!((about(PARAMETERS), about(BODIES)), if in_any_motion { (0, 1) } else { (1, 0) });
        }
    }
}
