//! Judges an identification by logs that were not fitted, and withholds results if necessary. The program and Python use it.
//!
//! If the verdict is no, files for a simulator are withheld, that is, not written.

use identification::estimate::logs_left_out::LogLeftOut;
use identification::estimate::residuals::Residuals;
use identification::estimate::verdict::{Prediction, Trust, Verdict};
use logs::LogSource;
use numerics::triangle::Triangle;

use crate::describe::model::Model;
use crate::error::Error;
use crate::fit::samples::Identification;
use crate::fit::validation::{Predicted, Validation, predictions};

/// The verdict on an identification, and the predictions on which the verdict is based.
pub struct JudgedIdentification {
    /// Name and residuals of each log that was not fitted.
    pub predictions: Vec<(String, Residuals)>,
    /// The predictions as the content of a result file; `None` if all logs were fitted.
    pub validation: Option<Validation>,
    /// Whether to trust the estimate.
    pub verdict: Verdict,
    /// Whether the results for a simulator are withheld because of the verdict.
    pub is_withheld: bool,
}

impl Identification {
    /// Predicts logs that were not fitted, and judges the estimate. Results that the verdict forbids are withheld, unless
    /// `anyway` is set.
    ///
    /// Fails if a log cannot be read.
    pub fn verdict_of_logs(
        &mut self,
        model: &Model,
        others: &[LogSource],
        anyway: bool,
    ) -> Result<JudgedIdentification, Error> {
        let predicted = predictions(self.used(model), &self.estimate, self.unsure.covariance(), others)?;
        let new = predicted.iter().filter(|log| self.is_new(log));
        let new: Vec<&[Triangle]> = new.map(|log| log.joints.as_slice()).collect();
        if let Some(errors) = self.unsure.errors_with(self.used(model), &self.estimate, &new) {
            self.estimate.torque_errors = errors;
        }
        let contacts = predicted.iter().flat_map(|log| log.contacts.iter().cloned());
        self.log_check.contacts = contacts.collect();
        let verdict = self.judge(self.prediction(&predicted));
        let predictions: Vec<(String, Residuals)> = predicted.into_iter().map(|p| (p.log, p.residuals)).collect();
        if let Some(bodies) = self.bodies.as_mut().filter(|_| anyway) {
            bodies.refusal = None;
        }
        let model = self.used(model);
        let (reference, estimate) = (model.reference.clone(), &self.estimate);
        let validation = (!predictions.is_empty()).then(|| {
            Validation::of_logs(reference, &estimate.method, estimate.cutoff, model.regressor(), &predictions)
        });
        let is_withheld = verdict.of_bodies().0 == Trust::No && !anyway;
        Ok(JudgedIdentification { predictions, validation, verdict, is_withheld })
    }

    /// Whether the motion of a log differs from the motion of the fitted logs.
    fn is_new(&self, log: &Predicted) -> bool {
        log.visited.is_other_than(&self.log_check.visited)
    }

    /// The prediction error that the verdict uses. If there are logs that were not fitted, this is the largest error on these
    /// logs. Otherwise, each fitted log is predicted by parameters that are fitted to the other logs only. Of these
    /// predictions, the verdict uses the one with the smallest error by parameters (the part of the error that other parameter
    /// values could remove). A large error of a single prediction does not count, because it may only mean that the other logs
    /// identify too little.
    fn prediction(&self, logs: &[Predicted]) -> Prediction {
        let apart = self.logs_left_out.iter().max_by(|a, b| a.apart.total_cmp(&b.apart));
        let prediction = Prediction { most_apart: apart.map(|left| (left.log, left.apart)), ..Prediction::default() };
        if logs.is_empty() {
            return self.of_the_fit(prediction);
        }
        let new: Vec<&Predicted> = logs.iter().filter(|log| self.is_new(log)).collect();
        let counted: Vec<&Predicted> = if new.is_empty() { logs.iter().collect() } else { new };
        let worst = counted.iter().max_by(|a, b| a.error.total_cmp(&b.error));
        Prediction {
            others: worst.map(|p| p.error),
            others_repeat: !counted.iter().any(|p| self.is_new(p)),
            others_nominal: worst.and_then(|p| p.described),
            others_unsure: worst.and_then(|p| p.unsure),
            others_by_parameters: counted.iter().map(|p| p.by_parameters()).reduce(f64::max),
            ..prediction
        }
    }

    /// Adds the error on one fitted log, predicted from the other fitted logs.
    fn of_the_fit(&self, prediction: Prediction) -> Prediction {
        let is_new = |left: &LogLeftOut| self.log_check.visited.is_new_log(left.log);
        let has_new = self.logs_left_out.iter().any(is_new);
        let counted = self.logs_left_out.iter().filter(|left| is_new(left) == has_new);
        let best = counted.min_by(|a, b| a.by_parameters.total_cmp(&b.by_parameters));
        Prediction {
            others: best.map(|left| left.error),
            others_repeat: !has_new,
            others_nominal: best.and_then(|left| left.described),
            others_unsure: best.map(|left| left.unsure),
            others_by_parameters: best.map(|left| left.by_parameters),
            others_are_of_the_fit: true,
            ..prediction
        }
    }
}
