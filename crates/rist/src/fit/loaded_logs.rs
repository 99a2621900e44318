//! Logs that were read with a model and options: the records, the log check, and possibly the regression rows of these logs.
//!
//! A record is a log with filtered signals at the samples of the fit. The log check compares the records with the description.
//! The regression rows are W and tau of the equations tau = W X (X: parameters).

use identification::estimate::identify::Fit;
use identification::estimate::log_check::LogCheck;
use identification::estimate::options::Options;
use identification::estimate::rotors::WithRotors;
use identification::rows::observation::{Observation, SinglePass};
use identification::signals::records::SourceRecords;
use logs::LogSource;

use crate::describe::model::Model;
use crate::error::Error;
use crate::fit::doctor::log_check_of;
use crate::fit::undetermined::may_lack_rotors;

/// Logs that were read, with the results computed from them.
pub(crate) struct LoadedLogs<'a> {
    /// The options with which the logs were read. Other options need a new reading.
    pub options: Options,
    pub records: SourceRecords<'a>,
    pub log_check: LogCheck,
    /// The rows of the equations; `None` if the rows were not computed.
    pub rows: Option<Observation>,
    /// The rows with columns for rotor inertias; `None` if these rows were not computed.
    pub with_rotors: Option<WithRotors>,
}

impl<'a> LoadedLogs<'a> {
    /// Reads and checks logs. Fails if a log cannot be read.
    pub(crate) fn of(model: &'a Model, logs: &'a [LogSource], options: &Options) -> Result<LoadedLogs<'a>, Error> {
        let records = SourceRecords::new(model.regressor(), logs, &options.preparation())?;
        let gains = options.transmission.drive_gains.as_deref();
        let (log_check, rows, with_rotors) = match records.are_made_anew() {
            false => (log_check_of(model, logs, &records, gains, options)?, None, None),
            // These records are computed again on each use. So the rows are computed in the same pass as the log check.
            true => {
                let (regressor, lacks_rotors) = (model.regressor(), may_lack_rotors(model));
                let look = |records: &SinglePass<SourceRecords<'_>>| log_check_of(model, logs, records, gains, options);
                let wide =
                    lacks_rotors.then(|| WithRotors::in_one_pass(regressor, &records, options, look)).transpose()?;
                match wide.flatten() {
                    Some((log_check, with_rotors)) => (log_check, None, with_rotors),
                    None => {
                        let linear = options.linear_model(regressor);
                        let (log_check, rows) = Observation::in_one_pass(&linear, &records, look)?;
                        (log_check, rows, None)
                    }
                }
            }
        };
        Ok(LoadedLogs { options: options.clone(), records, log_check, rows, with_rotors })
    }

    /// Fits the parameters to the logs, with the options that the logs were read with.
    ///
    /// Fails if a log cannot be read, or if no joint moves.
    pub(crate) fn fit(&self, model: &Model, logs: &[LogSource]) -> Result<Fit, Error> {
        let (regressor, names) = (model.regressor(), logs.iter().map(LogSource::name).collect());
        let rows = match (&self.rows, &self.with_rotors) {
            (Some(rows), _) => Some(rows.clone()),
            (None, with_rotors) => with_rotors.as_ref().map(|rows| rows.without(regressor, &self.options)),
        };
        Ok(match rows {
            Some(rows) => Fit::of_observation(regressor, &self.records, rows, names, &self.options)?,
            None => Fit::of_records(regressor, &self.records, names, &self.options)?,
        })
    }
}
