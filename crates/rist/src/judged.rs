//! Predicts, judges and withholds: what the program and Python do with an identification before they show it.

use identification::estimate::residuals::Residuals;
use identification::estimate::verdict::{Trust, Verdict};
use logs::LogSource;

use crate::error::Error;
use crate::model::Model;
use crate::samples::Identification;
use crate::validation::{Validation, predictions};

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
        let predictions = predictions(model, &self.estimate, others)?;
        let verdict = self.judge(predictions.iter().map(|(_, p)| p.total).reduce(f64::max));
        if let Some(bodies) = self.bodies.as_mut().filter(|_| anyway) {
            bodies.refusal = None;
        }
        let (reference, estimate) = (model.reference.clone(), &self.estimate);
        let validation = (!predictions.is_empty()).then(|| {
            Validation::of_logs(reference, &estimate.method, estimate.cutoff, model.regressor(), &predictions)
        });
        let is_withheld = verdict.trust == Trust::No && !anyway;
        Ok(Judged { predictions, validation, verdict, is_withheld })
    }
}
