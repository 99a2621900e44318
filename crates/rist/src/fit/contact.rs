//! Intervals of a log in which the residual is an outlier, such as a contact, and fits to the rows outside these intervals.
//!
//! Contacts are searched in the residual of a fit or of a prediction. Contacts explain the residual if it is much smaller
//! without these rows.

use identification::estimate::digits::percent;
use identification::estimate::held_out;
use identification::estimate::options::Options;
use identification::estimate::standing_out::{MOST_INTERVALS, StandingOut, merged, standing_out};
use identification::estimators::weighted::{Weights, fit};
use identification::rows::observation::Observation;
use identification::signals::records::SourceRecords;
use identification::signals::signal_options::LeftOutInterval;
use logs::LogSource;
use numerics::triangle::Triangle;

use crate::describe::model::Model;
use crate::error::Error;

/// Intervals in which the residual is an outlier, and options that leave the rows of these intervals out.
pub(crate) struct Contacts {
    pub(crate) events: Vec<StandingOut>,
    /// The options, with the intervals in `leave_out`.
    pub(crate) options: Options,
    /// Relative residuals: of all rows, and of the rows that remain.
    pub(crate) errors: [f64; 2],
}

/// Largest number of searches for intervals. After each search, the fit is repeated without the rows of contact, because a
/// strong contact hides weak ones. The search ends earlier if no new interval is found.
const MOST_ROUNDS: usize = 4;
/// Contacts explain the residual if the residual without the rows of contact, divided by the residual with them, is at most
/// this value.
const EXPLAINING_ERROR_RATIO: f64 = 0.8;
/// Number of parts of a second to which the ends of the intervals are rounded.
const PARTS_OF_SECOND: f64 = 100.0;

impl Contacts {
    /// The contacts in logs. The parameters are fitted to the rows outside the contacts.
    ///
    /// Fails if a log cannot be read.
    pub(crate) fn of_logs(model: &Model, logs: &[LogSource], options: &Options) -> Result<Contacts, Error> {
        // Robust weights would need the single rows. Here only one triangle per joint is available (R of the QR decomposition
        // of its regression rows), so weights by joint are used instead.
        let weights = if options.weights.losses().is_empty() { options.weights } else { Weights::Joint };
        Contacts::find(model, logs, options, MOST_ROUNDS, &|joints| fit(joints, weights).0.x)
    }

    /// The contacts in logs that are predicted by the parameters x.
    ///
    /// Fails if a log cannot be read.
    pub(crate) fn of_prediction(
        model: &Model,
        x: &[f64],
        logs: &[LogSource],
        options: &Options,
    ) -> Result<Contacts, Error> {
        // The parameters are given, so a contact hides no other contact. One search is enough, and the second round only
        // computes the error.
        Contacts::find(model, logs, options, 1, &|_| x.to_vec())
    }

    /// `rounds`: number of searches; `parameters`: computes the parameters from the rows that remain.
    fn find(
        model: &Model,
        logs: &[LogSource],
        options: &Options,
        rounds: usize,
        parameters: &dyn Fn(&[Triangle]) -> Vec<f64>,
    ) -> Result<Contacts, Error> {
        let mut found = Contacts { events: Vec::new(), options: options.clone(), errors: [f64::INFINITY; 2] };
        for round in 0..=rounds {
            let linear = found.options.linear_model(model.regressor());
            let read = || -> Result<_, Error> {
                let records = SourceRecords::new(model.regressor(), logs, &found.options.preparation())?;
                let joints = Observation::of_records(&linear, &records, None)?.joints(|_| true);
                Ok((records, joints))
            };
            let (records, joints) = match read() {
                // Too few rows remain for a fit, so the intervals explain nothing.
                Err(_) if round > 0 => {
                    found.errors[1] = found.errors[0];
                    found.options = options.clone();
                    break;
                }
                outcome => outcome?,
            };
            let x = parameters(&joints);
            found.errors[1] = held_out::residuals(&linear, &joints, &x).total;
            if round == 0 {
                found.errors[0] = found.errors[1];
            }
            if round == rounds {
                break;
            }
            let mut events = standing_out(&linear, &records, &x)?;
            // Many intervals of one joint mean an error of the model, not contact. So these intervals are dropped.
            events.retain(|event| event.joints.iter().any(|&joint| found.count(event.log, joint) < MOST_INTERVALS));
            if events.is_empty() {
                break;
            }
            found.add(events, logs);
        }
        Ok(found)
    }

    fn count(&self, log: usize, joint: usize) -> usize {
        self.events.iter().filter(|event| event.log == log && event.joints.contains(&joint)).count()
    }

    fn add(&mut self, events: Vec<StandingOut>, logs: &[LogSource]) {
        let interval = |event: &StandingOut| {
            let [from, to] = event.reach().map(|t| t * PARTS_OF_SECOND);
            let seconds = [from.floor(), to.ceil()].map(|t| t / PARTS_OF_SECOND);
            Some(LeftOutInterval { log: logs.get(event.log)?.name(), seconds })
        };
        self.options.signal.leave_out.extend(events.iter().filter_map(interval));
        self.events = merged(std::mem::take(&mut self.events).into_iter().chain(events).collect());
    }

    /// Whether the contacts explain the residual.
    pub(crate) fn explain(&self) -> bool {
        !self.events.is_empty() && self.errors[1] <= EXPLAINING_ERROR_RATIO * self.errors[0]
    }

    /// A sentence on each interval. If the intervals explain the residual, the last sentence says so.
    pub(crate) fn sentences(&self, model: &Model, logs: &[LogSource]) -> Vec<String> {
        let name = |event: &StandingOut| logs.get(event.log).map_or_else(String::new, LogSource::name);
        let coordinates = model.regressor().coordinates();
        let sentence = |event: &StandingOut| event.statement(coordinates, &name(event));
        let mut sentences: Vec<String> = self.events.iter().map(sentence).collect();
        if let Some(last) = sentences.last_mut().filter(|_| self.explain()) {
            let [with, without] = self.errors.map(percent);
            *last = format!("{last}; without these rows the residual is {without} instead of {with}");
        }
        sentences
    }

    /// The sentences on the intervals. If the intervals explain the residual, the last sentence names the option that leaves
    /// their rows out.
    pub(crate) fn sentences_with_remedy(&self, model: &Model, logs: &[LogSource]) -> Vec<String> {
        let mut sentences = self.sentences(model, logs);
        if let Some(last) = sentences.last_mut().filter(|_| self.explain()) {
            last.push_str(" ([:identify] [leave_out_contact])");
        }
        sentences
    }
}
