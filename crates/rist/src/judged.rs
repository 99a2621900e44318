//! Predicts, judges and withholds: what the program and Python do with an identification before they show it.

use identification::estimate::residuals::Residuals;
use identification::estimate::verdict::{Prediction, Trust, Verdict};
use logs::LogSource;

use crate::error::Error;
use crate::model::Model;
use crate::samples::Identification;
use crate::validation::{Predicted, Validation, predictions};

/// What is said of an identification, and what it predicts.
pub struct Judged {
    /// Residuals by log, of logs that were not fitted.
    pub predictions: Vec<(String, Residuals)>,
    /// The same as an artefact; `None` where there are no such logs.
    pub validation: Option<Validation>,
    /// Whether to trust the estimate.
    pub verdict: Verdict,
    /// Whether nothing may be written for a simulator.
    pub is_withheld: bool,
}

impl Identification {
    /// Predicts logs that were not fitted, and judges the estimate; what a verdict of no forbids is withheld, unless
    /// `anyway`.
    ///
    /// Fails where a log cannot be read.
    pub fn judged(&mut self, model: &Model, others: &[LogSource], anyway: bool) -> Result<Judged, Error> {
        let predicted = predictions(self.used(model), &self.estimate, self.covariance.as_deref(), others)?;
        if let Some(errors) = self.torque_errors_beside(self.used(model), &predicted) {
            self.torque_errors = errors;
        }
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
        Ok(Judged { predictions, validation, verdict, is_withheld })
    }

    /// What the logs that were not fitted say of it: the worst of them.
    fn prediction(&self, logs: &[Predicted]) -> Prediction {
        let new: Vec<&Predicted> = logs.iter().filter(|p| p.visited.is_other_than(&self.passport.visited)).collect();
        let counted: Vec<&Predicted> = if new.is_empty() { logs.iter().collect() } else { new };
        let worst = counted.iter().max_by(|a, b| a.residuals.total.total_cmp(&b.residuals.total));
        Prediction {
            others: worst.map(|p| p.residuals.total),
            others_repeat: !counted.iter().any(|p| p.visited.is_other_than(&self.passport.visited)),
            others_described: worst.and_then(|p| p.described),
            others_unsure: worst.and_then(|p| p.unsure),
            others_by_parameters: counted.iter().map(|p| p.by_parameters()).reduce(f64::max),
            ..Prediction::default()
        }
    }
}
