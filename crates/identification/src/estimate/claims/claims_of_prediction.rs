//! Makes claims (statements with their evidence) on how well an estimate predicts data that were not fitted: other logs, or
//! left-out blocks of the fitted logs (cross-validation).
//!
//! Relative error: |tau - W X| / |tau| with the measured torques tau, the regressor W and the parameters X. The description:
//! the nominal parameters of the robot description, with fitted friction.

use claims::{Claim, Outcome, Remedy, Subject};

use crate::estimate::artefact::Estimate;
use crate::estimate::claims::noise::is_noise;
use crate::estimate::digits::percent;
use crate::estimate::topics::{OTHER_MOTION, agrees, cannot_tell, contradicted};

/// A prediction of another motion is good up to this relative error.
const GOOD_PREDICTION_ERROR: f64 = 0.05;
/// If the residual is noise, a prediction is good up to this relative error, because no parameters can predict noise.
const GOOD_NOISY_PREDICTION_ERROR: f64 = 0.2;
/// A prediction of data that were not fitted is useless above this relative error.
const USELESS_PREDICTION_ERROR: f64 = 0.5;
/// The description predicts another log better if the error of the estimate exceeds the error of the description by this
/// factor. Noise changes the ratio by some hundredths.
const WORSE_ERROR_RATIO: f64 = 1.05;
/// The estimate contradicts another log if the error of the estimate on that log exceeds the error of the description by this
/// factor.
const FAR_WORSE_ERROR_RATIO: f64 = 2.0;
/// A prediction error is explained by the standard deviations of the parameters if it is at most this many times the rms error
/// that these deviations cause.
const EXPLAINED_DEVIATIONS: f64 = 2.0;
/// The parameters are overfitted (valid for their own log only) if the error on other data exceeds the residual of the fit by
/// this factor.
const OVERFITTED_ERROR_RATIO: f64 = 2.0;
/// An error on data that were not fitted, relative to the torque, is accepted up to this value, even if the description
/// predicts better.
const SMALL_HELD_OUT_ERROR: f64 = 0.02;

/// Text in a claim: why no remedy for a bad prediction was tried.
const UNKNOWN_CAUSE: &str = "nothing is known of the cause";

/// Relative errors |tau - W X| / |tau| of an estimate on data that were not fitted; `None` if not computed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Prediction {
    /// Whether the residual is much larger in some short intervals. The cause is then an event such as a contact, not a lack of
    /// motion in the log.
    pub has_events: bool,
    /// Relative error of the predicted torques of other logs.
    pub others: Option<f64>,
    /// Whether the motion of the other logs repeats the fitted motion.
    pub others_repeat: bool,
    /// Relative error on the other logs with the nominal parameters and fitted friction.
    pub others_nominal: Option<f64>,
    /// Relative error on the other logs that the standard deviations of the parameters explain; `None` without a covariance.
    pub others_unsure: Option<f64>,
    /// Error on other logs that comes from wrong parameters: sqrt(p^2 - f^2), the largest value of all logs. p: relative
    /// error of the prediction; f: relative residual of a fit to that log alone.
    pub others_by_parameters: Option<f64>,
    /// Whether the other logs are logs of the fit. Each of them is then predicted by parameters that are fitted to all other
    /// logs.
    pub others_are_of_the_fit: bool,
    /// The log with the largest error due to the common fit: its index, and sqrt(c^2 - a^2). c, a: relative residuals with
    /// parameters fitted to all logs, and to this log alone.
    pub most_apart: Option<(usize, f64)>,
    /// Relative error of cross-validation: blocks of the fitted logs are left out and predicted.
    pub held_out: Option<f64>,
    /// Whether most of the motion is not repeated: most states (q, dq) of a block occur in no other block.
    pub parts_are_new: bool,
}

impl Prediction {
    /// Whether the logs of the fit are consistent, although one log is predicted badly by parameters fitted to the other logs.
    /// The prediction error must be at most `GOOD_NOISY_PREDICTION_ERROR`. In addition, standard deviations of the parameters
    /// must explain the error, or the common fit of all logs must be nearly as good as separate fits.
    fn is_of_poor_logs(&self) -> bool {
        let is_in_reach = self.others.is_some_and(|error| error <= GOOD_NOISY_PREDICTION_ERROR);
        let both = self.others_by_parameters.zip(self.others_unsure);
        let is_explained =
            both.is_some_and(|(error, unsure)| unsure.is_finite() && error <= EXPLAINED_DEVIATIONS * unsure);
        let is_one = self.most_apart.is_some_and(|(_, apart)| apart <= SMALL_HELD_OUT_ERROR);
        self.others_are_of_the_fit && is_in_reach && (is_explained || is_one)
    }
}

/// The claims on a prediction. If logs of the fit contradict each other, this contradiction is the only claim.
pub(super) fn claims_of_prediction(estimate: &Estimate, prediction: &Prediction) -> Vec<Claim> {
    let apart = prediction.most_apart.filter(|(_, apart)| *apart > GOOD_PREDICTION_ERROR);
    let says_more = apart.is_none() || !prediction.others_are_of_the_fit;
    let more = says_more.then(|| other_motion(estimate, prediction));
    apart.map(|(log, apart)| contradiction(estimate, log, apart)).into_iter().chain(more).collect()
}

/// The claim that one set of parameters does not fit all logs. `log`: number of the worst log; `apart`: error of this log that
/// is due to the common fit.
fn contradiction(estimate: &Estimate, log: usize, apart: f64) -> Claim {
    let subject = Subject::whole(OTHER_MOTION);
    let name = estimate.logs.get(log).map_or("one", String::as_str);
    let why = format!(
        "the logs contradict each other: with parameters from all logs the residual of {name} grows by {} of its torque",
        percent(apart)
    );
    if apart <= GOOD_NOISY_PREDICTION_ERROR {
        return cannot_tell(subject, why, "logs of the robot as it is now");
    }
    let remedy = Remedy::new("identify", "identify from logs of one robot in one state; [:doctor] looks at each log");
    contradicted(subject, why, remedy, UNKNOWN_CAUSE)
}

/// The claim on the prediction of motion that was not fitted.
fn other_motion(estimate: &Estimate, prediction: &Prediction) -> Claim {
    let subject = Subject::whole(OTHER_MOTION);
    let would_tell = "a log of another motion, fitted together with this one ([:identify MODEL LOG LOG]) or predicted ([:validate MODEL ESTIMATE \
                      LOG], or [validate])";
    // If one log of the fit is predicted very badly by parameters fitted to the other logs, the other logs determine too few
    // parameters. Such an error is no contradiction.
    let others = prediction.others.filter(|e| !prediction.others_are_of_the_fit || *e < USELESS_PREDICTION_ERROR);
    // A good prediction counts only if the motion differs from the fitted motion. A bad prediction always counts.
    let of_logs = others.filter(|_| !prediction.others_repeat);
    let of_parts = prediction.held_out.filter(|_| prediction.parts_are_new);
    let worst = others.into_iter().chain(prediction.held_out).fold(0.0, f64::max);
    if worst >= USELESS_PREDICTION_ERROR {
        let (what, error) = match others.filter(|e| *e >= USELESS_PREDICTION_ERROR) {
            Some(error) => ("logs that were not fitted are", error),
            None => ("held-out parts of the log are", worst),
        };
        let fault = format!("{what} predicted with an error of {}", percent(error));
        let remedy = Remedy::new("doctor", "look what log and description have to do with each other");
        return contradicted(subject, fault, remedy, UNKNOWN_CAUSE);
    }
    if let Some(error) = of_logs.filter(|_| prediction.is_of_poor_logs()) {
        return agrees(subject, 100.0 * error, "% of the torque");
    }
    if let Some(rival) = of_logs.and_then(|error| rival(error, prediction)) {
        return rival;
    }
    let Some(error) = of_logs.or(of_parts) else {
        let why = match (prediction.others.is_some(), others.is_some(), prediction.others_are_of_the_fit) {
            (true, false, _) => {
                "no log is predicted by parameters from the others: these identify too few parameters alone"
            }
            (true, true, true) => "the logs repeat one motion",
            (true, true, false) => "the logs that were not fitted repeat the motion of those that were",
            (false, ..) => "no motion was predicted but the one that was fitted",
        };
        return Claim::new(subject, Outcome::NotLookedAt { why: why.into(), would_tell: would_tell.into() });
    };
    // Noise cannot be predicted, so a larger error is accepted if the residual is noise.
    let is_noise = is_noise(estimate) && estimate.total.is_some_and(|x| error < OVERFITTED_ERROR_RATIO * x);
    // An error that remains after a fit to the other log alone does not come from wrong parameters either.
    let is_least = of_logs.and(prediction.others_by_parameters).unwrap_or(error) <= GOOD_PREDICTION_ERROR;
    let most = if is_noise || is_least { GOOD_NOISY_PREDICTION_ERROR } else { GOOD_PREDICTION_ERROR };
    match error <= most {
        true => agrees(subject, 100.0 * error, "% of the torque"),
        false => cannot_tell(
            subject,
            format!("another motion is predicted with an error of {}", percent(error)),
            "what is missing in the model: [:doctor], [friction=auto]",
        ),
    }
}

/// The claim that the description predicts another log better than the identified parameters do. `error`: relative error of the
/// identified parameters. `None` if the difference is small, or if standard deviations explain the difference.
fn rival(error: f64, prediction: &Prediction) -> Option<Claim> {
    let described = prediction.others_nominal?;
    if error <= WORSE_ERROR_RATIO * described || error <= SMALL_HELD_OUT_ERROR {
        return None;
    }
    let subject = Subject::whole(OTHER_MOTION);
    let unsure = prediction.others_unsure.filter(|e| e.is_finite());
    let said = unsure.map_or(String::new(), |e| format!(", whose uncertainty is {}", percent(e)));
    let whose = if prediction.others_are_of_the_fit { "those from the other logs" } else { "these parameters" };
    let why = format!(
        "the description predicts the other log better ({}) than {whose} do ({}){said}",
        percent(described),
        percent(error)
    );
    let is_explained = error <= described.hypot(EXPLAINED_DEVIATIONS * prediction.others_unsure.unwrap_or(0.0));
    let is_far_worse = error > FAR_WORSE_ERROR_RATIO * described && error > GOOD_PREDICTION_ERROR;
    if is_far_worse && !is_explained {
        let remedy =
            Remedy::new("identify", "identify again from logs of this robot as it is now, or keep the description");
        return Some(contradicted(subject, why, remedy, UNKNOWN_CAUSE));
    }
    (is_far_worse || !is_explained).then(|| cannot_tell(subject, why, "a longer and richer motion ([:plan])"))
}

/// A sentence that the parameters are valid for their own log only (overfitted); `None` if the parameters are not overfitted.
pub(super) fn overfitted(estimate: &Estimate, prediction: &Prediction) -> Option<String> {
    if prediction.is_of_poor_logs() || prediction.has_events {
        return None;
    }
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

#[cfg(test)]
mod tests {
    use super::*;
    use claims::EvidenceLevel;

    #[test]
    fn a_better_description_counts_beyond_the_deviations() {
        let of = |error: f64, described: f64, unsure: Option<f64>| {
            let prediction = Prediction {
                others: Some(error),
                others_nominal: Some(described),
                others_unsure: unsure,
                ..Prediction::default()
            };
            other_motion(&Estimate::default(), &prediction).outcome().clone()
        };
        let why = |outcome: Outcome| match outcome {
            Outcome::CannotTell { why, .. } => why,
            other => panic!("{other:?}"),
        };
        // The standard deviations must explain sqrt(0.03^2 - 0.02^2) = 0.0224. Standard deviations explain an error up to twice
        // the rms error that they cause, so the limit of this rms error is 0.0112.
        assert!(matches!(of(0.03, 0.02, Some(0.0113)), Outcome::Agrees { .. }));
        let beyond = "the description predicts the other log better (2.00 %) than these parameters do (3.00 %)";
        assert_eq!(why(of(0.03, 0.02, Some(0.0111))), format!("{beyond}, whose uncertainty is 1.11 %"));
        assert_eq!(why(of(0.03, 0.02, None)), beyond);
        assert!(matches!(of(0.0205, 0.02, None), Outcome::Agrees { .. }));
        // The estimate is far worse than the description, and the error of the estimate exceeds the tolerance of a use. This is
        // a contradiction, unless standard deviations explain the error.
        assert!(matches!(of(0.06, 0.02, Some(0.028)), Outcome::Contradicted { .. }));
        assert!(why(of(0.06, 0.02, Some(0.029))).ends_with("whose uncertainty is 2.90 %"));
        assert!(why(of(0.06, 0.04, Some(0.1))).starts_with("another motion is predicted with an error"));
    }

    #[test]
    fn the_noise_of_another_log_is_its_own() {
        let of = |error: f64, by_parameters: Option<f64>| {
            let prediction =
                Prediction { others: Some(error), others_by_parameters: by_parameters, ..Prediction::default() };
            let estimate = Estimate { total: Some(0.01), ..Estimate::default() };
            let agrees = matches!(other_motion(&estimate, &prediction).outcome(), Outcome::Agrees { .. });
            (agrees, overfitted(&estimate, &prediction).is_some())
        };
        // The error due to the parameters is sqrt(0.12^2 - 0.115^2) = 0.034.
        assert_eq!(of(0.12, Some(0.034)), (true, false));
        assert_eq!(of(0.12, Some(0.06)), (false, true));
        assert_eq!(of(0.12, None), (false, true));
        // Above 20 %, the other log is too noisy to confirm the parameters. But wrong parameters cause only 3.4 %, so the
        // parameters are not overfitted.
        assert_eq!(of(0.25, Some(0.034)), (false, false));
    }

    #[test]
    fn a_log_that_tells_little_is_no_contradiction() {
        let of = |error: f64, unsure: f64, apart: f64, others_are_of_the_fit: bool| {
            let prediction = Prediction {
                others: Some(error),
                others_nominal: Some(0.01),
                others_unsure: Some(unsure),
                others_by_parameters: Some(error),
                others_are_of_the_fit,
                most_apart: Some((1, apart)),
                ..Prediction::default()
            };
            let estimate = Estimate {
                total: Some(0.01),
                logs: ["a.csv", "b.csv"].map(String::from).to_vec(),
                ..Estimate::default()
            };
            let claims = claims_of_prediction(&estimate, &prediction);
            let agrees = claims.iter().any(|claim| matches!(claim.outcome(), Outcome::Agrees { .. }));
            let standing = claims.iter().map(Claim::standing).collect::<Vec<_>>();
            let apart = claims.iter().map(ToString::to_string).find(|claim| claim.contains("contradict each other"));
            (agrees, standing, apart.unwrap_or_default())
        };
        let agrees = |error, unsure, apart, of_the_fit| of(error, unsure, apart, of_the_fit).0;
        assert!(agrees(0.12, 0.07, 0.03, true) && !agrees(0.12, 0.05, 0.03, true) && agrees(0.12, 0.05, 0.01, true));
        assert!(!agrees(0.12, f64::INFINITY, 0.03, true) && agrees(0.12, f64::INFINITY, 0.01, true));
        assert!(!agrees(0.25, 0.2, 0.01, true) && !agrees(0.12, 0.07, 0.01, false));
        for (apart, of_the_fit, expected) in [
            (0.03, true, vec![EvidenceLevel::Agreed]),
            (0.06, true, vec![EvidenceLevel::Open]),
            (0.06, false, vec![EvidenceLevel::Open, EvidenceLevel::Open]),
            (0.21, true, vec![EvidenceLevel::Refused]),
        ] {
            let (_, standing, said) = of(0.12, 0.07, apart, of_the_fit);
            assert_eq!(standing, expected, "{apart}");
            let sentence = format!(
                "with parameters from all logs the residual of b.csv grows by {} of its torque",
                percent(apart)
            );
            assert_eq!(said.contains(&sentence), apart > 0.05, "{said}");
        }
    }
}
