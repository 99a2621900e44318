//! Searches the best variant: a model, and the options of its fit.
//!
//! Decisions that the request leaves free are tried one after the other. Each candidate proposes a variant, and computes the
//! error E of the fit without and with the variant, on segments of the logs that are held out in turn. A variant is kept if
//!
//! ```text
//! E(with) <= limit E(without)
//! ```
//! and if E(without) is not negligible. A variant with a significant unknown is kept if E falls at all. Decisions that follow
//! from the request or from the columns of a log need no errors. If a variant changes the model, the search starts again,
//! because earlier decisions were made with the old model.
//!
//! The error of each log predicted from the other logs is not used, because the true variant predicts a poor log worse (seeds
//! 9252, 9359 and 9473 of the bench `random_situations`: torques would be 7 to 11 % wrong instead of 1 %).
//!
//! The log check compares logs with the description before a fit; one of its findings is another mount (orientation) of the
//! base. A fault is a possible mistake of a log, tested as one additional unknown of the fit. Unknowns are quantities besides
//! the parameters: mount, encoder zeros, torque scales, springs.

use claims::{Claim, Topic};
use identification::estimate::claims::hypotheses::{Hypothesis, HypothesisTest, UndeterminedMechanics, hypotheses};
use identification::estimate::claims::unknowns::UnknownStep;
use identification::estimate::delay::Delay;
use identification::estimate::held_out::cross_validate;
use identification::estimate::identify::Fit;
use identification::estimate::joint_terms::JointTerms;
use identification::estimate::log_check::LogCheck;
use identification::estimate::log_check::finding::Fault;
use identification::estimate::options::Options;
use identification::estimate::selection::FrictionSelection;
use identification::estimate::standing_out::standing_out;
use identification::estimate::topics::mended;
use identification::estimators::drive_gains::likelihood::DriveGains;
use identification::rows::observation::Observation;
use identification::signals::records::SourceRecords;
use logs::{Effort, LogSource};

use crate::describe::model::Model;
use crate::error::Error;
use crate::fit::contact::Contacts;
use crate::fit::loaded_logs::LoadedLogs;
use crate::fit::undetermined::with_undetermined;
use crate::request::SamplesRequest;

/// A variant is kept if the error on held-out data with the variant, divided by the error without it, is at most this value.
pub(crate) const WORTHWHILE_ERROR_RATIO: f64 = 0.97;
/// Relative errors on held-out data below this value are rounding errors, so differences between such errors do not count.
const NEGLIGIBLE_ERROR: f64 = 1e-3;

/// Selects which parameters an identification keeps, and whether the bodies must be physically possible.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum KeptParameters {
    /// All parameters. If the logs are poor, the bodies are restricted to physically possible bodies.
    All,
    /// All parameters, even if the bodies are physically impossible.
    Free,
    /// Only the essential parameters (the smallest set with nearly the same residual). All other parameters are zero.
    Essential,
    /// All parameters, with physically possible bodies. Parameters that the logs do not identify get values from the
    /// description.
    Consistent,
}

/// A choice of a model, and of options for its fit.
pub(crate) struct Variant {
    /// The changed model; `None` if the model of the search is kept.
    pub model: Option<Model>,
    pub options: Options,
}

/// Relative error of the fit on held-out segments of logs, each predicted from the other segments. Reads the logs again.
///
/// Fails if a log cannot be read.
pub(crate) fn error_on_parts(model: &Model, logs: &[LogSource], options: &Options) -> Result<f64, Error> {
    let linear = options.linear_model(model.regressor());
    let records = SourceRecords::new(model.regressor(), logs, &options.preparation())?;
    let rows = Observation::of_records(&linear, &records, None)?;
    Ok(cross_validate(&linear, &rows, options.weights).total)
}

/// The evidence by which a variant is kept or rejected.
pub(crate) enum Evidence {
    /// The variant follows from the request, or from the columns of the logs.
    Given,
    /// The errors on held-out data without and with the variant; the second has to be at most `limit` times the first.
    Errors { errors: [f64; 2], limit: f64 },
    /// An unknown of the variant is significant. The variant is then kept if the error on held-out data falls at all. The two
    /// errors are without and with the variant.
    Significant([f64; 2]),
}

impl Evidence {
    /// Whether the variant is kept. The rule is in the documentation of this module.
    pub(crate) fn is_enough(&self) -> bool {
        match *self {
            Evidence::Given => true,
            Evidence::Errors { errors: [without, with], limit } => {
                without >= NEGLIGIBLE_ERROR && with <= limit * without
            }
            Evidence::Significant([without, with]) => with < without,
        }
    }
}

/// A variant that a candidate proposes, with its evidence.
pub(crate) struct Proposal {
    pub variant: Variant,
    pub evidence: Evidence,
    /// The decisions that lead to this variant, for the user.
    pub found: Decisions,
}

impl Proposal {
    /// A proposal that follows from the request, or from the columns of the logs.
    pub(crate) fn given(options: Options, found: Decisions) -> Proposal {
        Proposal { variant: Variant { model: None, options }, evidence: Evidence::Given, found }
    }

    /// A proposal that the request does not ask for. `sentence` is shown to the user.
    pub(crate) fn mending(variant: Variant, evidence: Evidence, topic: Topic, sentence: String) -> Proposal {
        let found =
            Decisions { mended: vec![mended(topic, &sentence)], sentences: vec![sentence], ..Decisions::default() };
        Proposal { variant, evidence, found }
    }
}

/// The decisions that a search makes before the fit.
#[derive(Default)]
pub struct Decisions {
    /// The drive gains, if some were estimated.
    pub gains: Option<DriveGains>,
    /// The delay, if one was found.
    pub delay: Option<Delay>,
    /// The friction terms for all joints, if the request lets the search choose them.
    pub friction: Option<FrictionSelection>,
    /// The additional friction terms of single joints, if the request lets the search choose them.
    pub joint_terms: Option<JointTerms>,
    /// The last Gauss-Newton step of each unknown. The values of the unknowns are in the options and the description.
    pub unknowns: Vec<UnknownStep>,
    /// Whether the parameters are restricted to physically possible bodies although the request does not require this.
    pub possible_bodies: bool,
    /// A sentence on each decision.
    pub sentences: Vec<String>,
    /// Corrections that the request did not ask for, with the errors without and with the correction.
    pub mended: Vec<Claim>,
}

impl Decisions {
    fn then(mut self, mut later: Decisions) -> Decisions {
        self.sentences.append(&mut later.sentences);
        self.mended.append(&mut later.mended);
        self.unknowns.append(&mut later.unknowns);
        Decisions {
            gains: later.gains.or(self.gains),
            delay: later.delay.or(self.delay),
            friction: later.friction.or(self.friction),
            joint_terms: later.joint_terms.or(self.joint_terms),
            possible_bodies: later.possible_bodies || self.possible_bodies,
            ..self
        }
    }
}

/// The logs, the request for the fit of these logs, and the parameters to keep.
#[derive(Clone, Copy)]
pub(crate) struct FitQuestion<'a> {
    pub logs: &'a [LogSource],
    pub request: &'a SamplesRequest,
    pub kept: KeptParameters,
}

/// A fit, with the log faults that were tested as additional unknowns.
pub(crate) struct Fitted {
    pub fit: Fit,
    pub faults: Vec<HypothesisTest>,
}

/// The variant that is being tried. The logs and the fit of this variant are computed on demand.
pub(crate) struct TriedVariant<'a> {
    pub model: &'a Model,
    pub asked: FitQuestion<'a>,
    /// The options at the start of the search.
    pub start: Options,
    pub options: Options,
    looked: Option<LoadedLogs<'a>>,
    fitted: Option<Fitted>,
}

impl<'a> TriedVariant<'a> {
    /// A variant with the same logs and model, but with other options. The logs are read only when they are needed.
    pub(crate) fn with_options(&self, options: Options) -> TriedVariant<'a> {
        TriedVariant { options, start: self.start.clone(), looked: None, fitted: None, ..*self }
    }

    fn take(&mut self, options: Options) {
        if options != self.options {
            (self.options, self.looked, self.fitted) = (options, None, None);
        }
    }

    /// The logs with their check. The logs are read at the first call.
    ///
    /// Fails if a log cannot be read.
    pub(crate) fn looked(&mut self) -> Result<&mut LoadedLogs<'a>, Error> {
        let looked = match self.looked.take() {
            Some(looked) => looked,
            None => LoadedLogs::of(self.model, self.asked.logs, &self.options)?,
        };
        Ok(self.looked.insert(looked))
    }

    /// The fit, computed at the first call.
    ///
    /// Fails if a log cannot be read, or if no joint moves.
    pub(crate) fn fitted(&mut self) -> Result<&Fitted, Error> {
        let fitted = match self.fitted.take() {
            Some(fitted) => fitted,
            None => self.fit()?,
        };
        Ok(self.fitted.insert(fitted))
    }

    fn fit(&mut self) -> Result<Fitted, Error> {
        let (model, logs, options) = (self.model, self.asked.logs, self.options.clone());
        let linear = options.linear_model(model.regressor());
        let looked = self.looked()?;
        let fit = looked.fit(model, logs)?;
        let are_currents = logs.iter().all(|log| log.effort_is() == Effort::Current);
        let drives = options.transmission.torque_per_current(model.regressor().coordinates().len());
        let drives = if are_currents { &drives[..] } else { &[] };
        let test = |open: UndeterminedMechanics<'_>| {
            hypotheses(&linear, &looked.records, fit.point(), UndeterminedMechanics { drives, ..open })
        };
        let mut faults = with_undetermined(model, None, test)?;
        // If the log check already reports another mount, the fit does not report this mount again.
        if looked.log_check.findings.iter().any(|finding| matches!(finding.fault, Fault::Mount(_))) {
            faults.retain(|fault| !matches!(fault.of, Hypothesis::Mount(_)));
        }
        Ok(Fitted { fit, faults })
    }

    /// Ends the search. Returns the log check, the fit, and one sentence for each interval of time in which the residual of a
    /// joint is an outlier.
    ///
    /// Fails if the fit fails.
    pub(crate) fn finish(mut self) -> Result<(LogCheck, Fitted, Vec<String>), Error> {
        let fitted = match self.fitted.take() {
            Some(fitted) => fitted,
            None => self.fit()?,
        };
        let (model, options) = (self.model, self.options.clone());
        let looked = self.looked()?;
        let linear = options.linear_model(model.regressor());
        // If the load changed during the log, the change explains the outliers, and they are not listed.
        let has_events = !looked.log_check.has_changed_load()
            && !standing_out(&linear, &looked.records, fitted.fit.point().x)?.is_empty();
        let log_check = std::mem::take(&mut looked.log_check);
        let events = match has_events {
            true => {
                let logs = self.asked.logs;
                Contacts::of_logs(model, logs, &self.options)?.sentences_with_remedy(model, logs)
            }
            false => Vec::new(),
        };
        Ok((log_check, fitted, events))
    }
}

/// Proposes a variant; `None` if there is no variant to try. Fails if a log cannot be read.
pub(crate) type VariantProposer = fn(&mut TriedVariant<'_>) -> Result<Option<Proposal>, Error>;

/// The result of a search.
pub(crate) struct SearchResult<T> {
    /// The model of the accepted variant; `None` if it is the given model.
    pub model: Option<Model>,
    pub options: Options,
    pub found: Decisions,
    pub end: T,
}

/// Tries the candidates in their order, and calls `end` with the accepted variant.
///
/// Fails if a candidate or `end` fails.
pub(crate) fn search<T>(
    model: &Model,
    asked: FitQuestion<'_>,
    options: Options,
    candidates: &[VariantProposer],
    end: &dyn Fn(TriedVariant<'_>) -> Result<T, Error>,
) -> Result<SearchResult<T>, Error> {
    let mut tried = TriedVariant { model, asked, start: options.clone(), options, looked: None, fitted: None };
    let mut found = Decisions::default();
    for (k, candidate) in candidates.iter().enumerate() {
        let Some(proposal) = candidate(&mut tried)?.filter(|proposal| proposal.evidence.is_enough()) else { continue };
        let Variant { model: changed, options } = proposal.variant;
        let Some(changed) = changed else {
            tried.take(options);
            found = found.then(proposal.found);
            continue;
        };
        drop(tried);
        let others = [&candidates[..k], &candidates[k + 1..]].concat();
        let searched = search(&changed, asked, options, &others, end)?;
        return Ok(SearchResult {
            model: searched.model.or(Some(changed)),
            found: proposal.found.then(searched.found),
            ..searched
        });
    }
    let options = tried.options.clone();
    Ok(SearchResult { model: None, options, found, end: end(tried)? })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_predicts_better_by_far_is_kept() {
        let by_far = |errors| Evidence::Errors { errors, limit: WORTHWHILE_ERROR_RATIO }.is_enough();
        assert!(by_far([0.1, 0.09]) && !by_far([0.1, 0.098]) && !by_far([5e-4, 1e-4]));
        let significant = |errors| Evidence::Significant(errors).is_enough();
        assert!(significant([0.1, 0.099]) && !significant([0.1, 0.101]));
    }
}
