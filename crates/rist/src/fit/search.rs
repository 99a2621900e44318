//! A search over variants of a model and of the options of its fit.
//!
//! What nobody decided is tried, candidate by candidate. Each proposes a variant with the error E of the fit without it and with
//! it, on parts of the logs that are left out in turn. A variant is kept where
//!
//! ```text
//! E(with) <= limit E(without)
//! ```
//! and E(without) is not negligible. An unknown beyond its deviations is kept where E falls at all. What follows from the columns
//! of a log or from the request needs no errors. A variant with another model starts the search over: what was decided with the
//! model before is decided anew.
//!
//! Not here: how well each of several logs is predicted from the others. Where one of them is poor it is predicted worse with what
//! is true (seeds 9252, 9359 and 9473 of the bench `random_situations`: torques 7 to 11 % wrong in place of 1 %).

use claims::{Claim, Topic};
use identification::estimate::delay::Delay;
use identification::estimate::held_out::cross_validate;
use identification::estimate::identify::Fit;
use identification::estimate::joint_terms::JointTerms;
use identification::estimate::ledger::hypotheses::{Hypothesis, Open, Tested, hypotheses};
use identification::estimate::ledger::unknowns::Step;
use identification::estimate::options::Options;
use identification::estimate::passport::Passport;
use identification::estimate::passport::finding::Fault;
use identification::estimate::selection::FrictionSelection;
use identification::estimate::standing_out::{StandingOut, standing_out};
use identification::estimate::topics::mended;
use identification::estimators::drive_gains::likelihood::DriveGains;
use identification::rows::observation::Observation;
use identification::signals::records::SourceRecords;
use logs::LogSource;

use crate::describe::model::Model;
use crate::error::Error;
use crate::fit::looked::Looked;
use crate::fit::unspoken::with_open;
use crate::request::SamplesRequest;

/// Error on parts left out over that without a candidate, up to which it is kept.
pub(crate) const WORTHWHILE_ERROR_RATIO: f64 = 0.97;
/// With errors below this nothing is left to explain, and a difference is rounding.
const NEGLIGIBLE_ERROR: f64 = 1e-3;

/// Which parameters are kept.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kept {
    /// All; of bodies that can exist where the logs are poor.
    All,
    /// All, whatever the bodies.
    Free,
    /// Those that the data need; the others are zero.
    Essential,
    /// All, of bodies that can exist. Where the logs do not determine them, the description does.
    Consistent,
}

/// A model, and the options of a fit of it.
pub(crate) struct Variant {
    /// `None`: the model as it is.
    pub model: Option<Model>,
    pub options: Options,
}

/// Error on parts of logs, each predicted from the others; the logs are read for it.
///
/// Fails where a log cannot be read.
pub(crate) fn error_on_parts(model: &Model, logs: &[LogSource], options: &Options) -> Result<f64, Error> {
    let linear = options.linear_model(model.regressor());
    let records = SourceRecords::new(model.regressor(), logs, &options.preparation())?;
    let rows = Observation::of_records(&linear, &records, None)?;
    Ok(cross_validate(&linear, &rows, options.weights).total)
}

/// Why a variant is kept.
pub(crate) enum Evidence {
    /// The request, or the columns of the logs.
    Given,
    /// The errors on parts left out without it and with it, where those fall by far: below `limit` of what they were.
    Errors { errors: [f64; 2], limit: f64 },
    /// An unknown beyond its deviations, where the errors fall with it at all.
    Significant([f64; 2]),
}

impl Evidence {
    /// The rule of this file.
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

/// What a candidate would change, and why.
pub(crate) struct Proposal {
    pub variant: Variant,
    pub evidence: Evidence,
    /// What is known with it.
    pub found: Decisions,
}

impl Proposal {
    /// Options that follow from the request, or from the columns of the logs.
    pub(crate) fn given(options: Options, found: Decisions) -> Proposal {
        Proposal { variant: Variant { model: None, options }, evidence: Evidence::Given, found }
    }

    /// What nobody asked for; `sentence` says so to the user.
    pub(crate) fn mending(variant: Variant, evidence: Evidence, topic: Topic, sentence: String) -> Proposal {
        let found =
            Decisions { mended: vec![mended(topic, &sentence)], sentences: vec![sentence], ..Decisions::default() };
        Proposal { variant, evidence, found }
    }
}

/// What a search decided beside the fit.
#[derive(Default)]
pub struct Decisions {
    /// The drive gains, where some were estimated.
    pub gains: Option<DriveGains>,
    /// The delay, where one was found.
    pub delay: Option<Delay>,
    /// The choice among sets of friction for all joints, where it was asked for.
    pub friction: Option<FrictionSelection>,
    /// The choice among terms of single joints, where it was asked for.
    pub joint_terms: Option<JointTerms>,
    /// The last step of unknowns; what they are stands in the options and the description.
    pub unknowns: Vec<Step>,
    /// Whether the parameters are those of bodies that can exist, which nobody asked for.
    pub possible_bodies: bool,
    /// A sentence on each decision.
    pub sentences: Vec<String>,
    /// What was mended without being asked for, with the errors without it and with it.
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

/// Logs, and what is asked of their fit.
#[derive(Clone, Copy)]
pub(crate) struct Asked<'a> {
    pub logs: &'a [LogSource],
    pub request: &'a SamplesRequest,
    pub kept: Kept,
}

/// A fit, with the unknowns that were tested beside it.
pub(crate) struct Fitted {
    pub fit: Fit,
    pub faults: Vec<Tested>,
}

/// The variant that is tried, with the logs as it reads them and its fit, once they are needed.
pub(crate) struct Tried<'a> {
    pub model: &'a Model,
    pub asked: Asked<'a>,
    /// The options that the search began with.
    pub start: Options,
    pub options: Options,
    looked: Option<Looked<'a>>,
    fitted: Option<Fitted>,
}

impl<'a> Tried<'a> {
    fn take(&mut self, options: Options) {
        if options != self.options {
            (self.options, self.looked, self.fitted) = (options, None, None);
        }
    }

    /// The logs, read at the first call.
    ///
    /// Fails where a log cannot be read.
    pub(crate) fn looked(&mut self) -> Result<&mut Looked<'a>, Error> {
        let looked = match self.looked.take() {
            Some(looked) => looked,
            None => Looked::of(self.model, self.asked.logs, &self.options)?,
        };
        Ok(self.looked.insert(looked))
    }

    /// The fit, made at the first call.
    ///
    /// Fails where a log cannot be read, and where no joint moves.
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
        let test = |open: Open<'_>| hypotheses(&linear, &looked.records, fit.point(), open);
        let mut faults = with_open(model, None, test)?;
        // A base that is found to be mounted otherwise is said once.
        if looked.passport.findings.iter().any(|finding| matches!(finding.fault, Fault::Mount(_))) {
            faults.retain(|fault| !matches!(fault.of, Hypothesis::Mount(_)));
        }
        Ok(Fitted { fit, faults })
    }

    /// The log check and the fit.
    ///
    /// Fails as [`Tried::fitted`] does.
    pub(crate) fn finish(mut self) -> Result<(Passport, Fitted, Vec<StandingOut>), Error> {
        let fitted = match self.fitted.take() {
            Some(fitted) => fitted,
            None => self.fit()?,
        };
        let (model, options) = (self.model, self.options.clone());
        let looked = self.looked()?;
        let linear = options.linear_model(model.regressor());
        // Another load is why residuals stand out.
        let events = match looked.passport.has_changed_load() {
            true => Vec::new(),
            false => standing_out(&linear, &looked.records, fitted.fit.point().x)?,
        };
        Ok((std::mem::take(&mut looked.passport), fitted, events))
    }
}

/// Proposes a variant; `None` where there is nothing to try. Fails where a log cannot be read.
pub(crate) type Candidate = fn(&mut Tried<'_>) -> Result<Option<Proposal>, Error>;

/// What a search ends with.
pub(crate) struct Searched<T> {
    /// The model, where it is another than the one given.
    pub model: Option<Model>,
    pub options: Options,
    pub found: Decisions,
    pub end: T,
}

/// Tries the candidates in their order, and does `end` with the variant that is left.
///
/// Fails where a candidate or `end` does.
pub(crate) fn search<T>(
    model: &Model,
    asked: Asked<'_>,
    options: Options,
    candidates: &[Candidate],
    end: &dyn Fn(Tried<'_>) -> Result<T, Error>,
) -> Result<Searched<T>, Error> {
    let mut tried = Tried { model, asked, start: options.clone(), options, looked: None, fitted: None };
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
        return Ok(Searched {
            model: searched.model.or(Some(changed)),
            found: proposal.found.then(searched.found),
            ..searched
        });
    }
    let options = tried.options.clone();
    Ok(Searched { model: None, options, found, end: end(tried)? })
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
