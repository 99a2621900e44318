//! Logs as a model and options read them: their records, the log check, and the rows where the pass made them.

use identification::estimate::identify::Fit;
use identification::estimate::options::Options;
use identification::estimate::passport::Passport;
use identification::estimate::rotors::WithRotors;
use identification::rows::observation::{Beside, Observation};
use identification::signals::records::SourceRecords;
use logs::LogSource;

use crate::describe::model::Model;
use crate::error::Error;
use crate::fit::doctor::passport_of;
use crate::fit::unspoken::may_lack_rotors;

/// Logs that were read, and what they were read with.
pub(crate) struct Looked<'a> {
    /// The options that they were read with: with others they must be read anew.
    pub options: Options,
    pub records: SourceRecords<'a>,
    pub passport: Passport,
    /// The rows, where they were made.
    pub rows: Option<Observation>,
    /// The rows with the columns of rotor inertias, where they were made.
    pub with_rotors: Option<WithRotors>,
}

impl<'a> Looked<'a> {
    /// Fails where a log cannot be read.
    pub(crate) fn of(model: &'a Model, logs: &'a [LogSource], options: &Options) -> Result<Looked<'a>, Error> {
        let records = SourceRecords::new(model.regressor(), logs, &options.preparation())?;
        let gains = options.transmission.drive_gains.as_deref();
        let (passport, rows, with_rotors) = match records.are_made_anew() {
            false => (passport_of(model, logs, &records, gains, options)?, None, None),
            // Going through states that are made anew costs more than making rows beside.
            true => {
                let (regressor, lacks_rotors) = (model.regressor(), may_lack_rotors(model));
                let look = |records: &Beside<SourceRecords<'_>>| passport_of(model, logs, records, gains, options);
                let wide = lacks_rotors.then(|| WithRotors::beside(regressor, &records, options, look)).transpose()?;
                match wide.flatten() {
                    Some((passport, with_rotors)) => (passport, None, with_rotors),
                    None => {
                        let linear = options.linear_model(regressor);
                        let (passport, rows) = Observation::beside(&linear, &records, look)?;
                        (passport, rows, None)
                    }
                }
            }
        };
        Ok(Looked { options: options.clone(), records, passport, rows, with_rotors })
    }

    /// The fit to them, with the options that they were read with.
    ///
    /// Fails where a log cannot be read, and where no joint moves.
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
