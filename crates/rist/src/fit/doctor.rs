//! Checks before a fit whether logs belong to the robot of a description.
//!
//! Input: logs and a description. Output: the log check, which lists findings (probable mistakes, each with a remedy),
//! properties that agree, and properties that cannot be determined. Logs are converted to records first: filtered signals at
//! the samples that a fit would use. A finding is gross if no estimate from these logs can be used. The mount is the
//! orientation of the base.

use identification::estimate::log_check::finding::{Fault, Finding};
use identification::estimate::log_check::{Change, Measured, log_check};
use identification::estimate::options::Options;
use identification::signals::records::{Records, SourceRecords};
use identification::signals::signal_options::Velocity;
use logs::{Effort, LogSource, NamePattern};

pub use identification::estimate::claims::claims_of_log;
pub use identification::estimate::log_check::LogCheck;

pub use crate::request::DoctorRequest;

use crate::describe::model::Model;
use crate::error::Error;
use crate::fit::contact::Contacts;
use crate::fit::drive_gains::OWN_SCALE;
use crate::fit::gravity_direction::look_for_mount;
use crate::fit::load::last_bodies;
use crate::fit::normalised::look_for_shares;
use crate::fit::signal_sources::sources;

/// Checks whether logs belong to the robot. If they do, contacts in the logs are named too. The logs are read as in an
/// identification with `options`.
///
/// Currents become torques by the drive gains of the options, or else by the drive gains of the description. Without gains,
/// currents are used unscaled, and the log check gives the gains that the description implies. Fails if a log cannot be read or
/// does not fit the robot.
pub fn examine(model: &Model, logs: &[LogSource], options: &Options) -> Result<LogCheck, Error> {
    let (mut found, options) = examine_columns(model, logs, options)?;
    if found.findings.is_empty() {
        found.contacts = Contacts::of_logs(model, logs, &options)?.sentences_with_remedy(model, logs);
    }
    Ok(found)
}

/// The check of [`examine`] without the search for contact, and the options with which the logs were read.
pub(crate) fn examine_columns(
    model: &Model,
    logs: &[LogSource],
    options: &Options,
) -> Result<(LogCheck, Options), Error> {
    let mut options = options.clone();
    let is_current = logs.iter().any(|log| log.effort_is().needs_gains());
    let are_known = options.transmission.drive_gains.is_some() || model.drive_gains().iter().all(Option::is_some);
    if is_current && options.transmission.drive_gains.is_none() {
        options.transmission.drive_gains = Some(model.drive_gains().into_iter().map(|g| g.unwrap_or(1.0)).collect());
    }
    let records = SourceRecords::new(model.regressor(), logs, &options.preparation())?;
    let gains = options.transmission.drive_gains.as_deref().filter(|_| are_known);
    let first = log_check_of(model, logs, &records, gains, &options)?;
    // Velocity and acceleration columns that are not the derivatives of the positions are ignored, so such columns cause no
    // findings.
    let mut chosen = options.clone();
    let mut found = match sources(&first, &mut chosen).is_empty() {
        true => first,
        false => {
            let records = SourceRecords::new(model.regressor(), logs, &chosen.preparation())?;
            log_check_of(model, logs, &records, gains, &chosen)?.with_columns_of(first)
        }
    };
    match are_known {
        false if logs.iter().any(|log| log.effort_is() == Effort::PositionError) => {
            found.efforts_are_position_errors(OWN_SCALE);
        }
        false if is_current => found.efforts_are_currents(),
        _ => {}
    }
    Ok((found, chosen))
}

impl DoctorRequest {
    /// The options for checking logs: the options of the request, including its sample rate and drive gains.
    ///
    /// Fails if a gain names an unknown coordinate.
    pub fn options(&self, model: &Model) -> Result<Options, Error> {
        let mut options = self.options.clone().unwrap_or_default();
        options.columns.rate = self.rate.or(options.columns.rate);
        if !self.gain.is_empty() {
            let mut all: Vec<f64> = model.drive_gains().into_iter().map(|gain| gain.unwrap_or(1.0)).collect();
            model.give_gains(&mut all, &self.gain)?;
            options.transmission.drive_gains = Some(all);
        }
        Ok(options)
    }
}

/// Writes a remedy (options to set) into each finding of a log check. Findings that explain the log only together get a common
/// remedy. A finding that other bodies (masses, inertias) could explain too gets its own remedy.
fn say_remedies(log_check: &mut LogCheck, logs: &[LogSource], options: &Options, model: &Model) {
    let Some(columns) = logs.first().map(LogSource::names) else { return };
    let are_alike = logs.iter().all(|log| log.names() == columns);
    let regressor = model.regressor();
    let turns: Vec<bool> = (0..regressor.coordinates().len()).map(|k| !regressor.is_prismatic(k)).collect();
    let say =
        |changes: &[Change]| options.undoing(changes, &columns, &turns).filter(|_| are_alike)?.remedy_added_to(options);
    let explanations = log_check.findings.iter().map(|f| f.instead + 1).max().unwrap_or(0);
    for number in 0..explanations {
        let is_of = |f: &&Finding| f.instead == number && !f.undo.is_empty();
        let together = log_check.findings.iter().filter(is_of).flat_map(|f| f.undo.iter().copied());
        let together = say(&together.collect::<Vec<Change>>());
        // Missing drive gains get no remedy here: gains are taken from a data sheet, because the description determines them
        // only roughly.
        let is_said = |f: &&mut Finding| f.instead == number && !f.undo.is_empty() && f.fault != Fault::NoTorque;
        for finding in log_check.findings.iter_mut().filter(is_said) {
            finding.remedy = together.clone().unwrap_or_else(|| BY_HAND.into());
        }
    }
    for explained in &mut log_check.explained {
        explained.finding.remedy = say(&explained.finding.undo).unwrap_or_else(|| BY_HAND.into());
    }
}

/// The remedy if no option can undo a finding.
const BY_HAND: &str = "write the log anew, with its columns in the order, sign and unit of the joints";

/// Checks logs by their records (the samples of the logs, prepared for a fit). `records`: made from the logs with `options`.
/// `gains`: the drive gains by which currents became torques, if they are known.
pub fn log_check_of<R: Records + ?Sized>(
    model: &Model,
    logs: &[LogSource],
    records: &R,
    gains: Option<&[f64]>,
    options: &Options,
) -> Result<LogCheck, Error> {
    let signal = &options.signal;
    let suspects: Vec<_> = logs.iter().flat_map(|log| log.report().suspect.clone()).collect();
    let look = |model: &Model| {
        let described = model.nominal_parameters();
        Ok(log_check(model.regressor(), records, &suspects, described.as_deref())?)
    };
    // Another mount of the base is searched before remedies are written, because another mount may replace findings.
    let mut found: LogCheck = look(model)?;
    look_for_mount(model, records, &mut found, look)?;
    say_remedies(&mut found, logs, options, model);
    look_for_shares(model, options, &mut found, |options| {
        let (records, described) =
            (SourceRecords::new(model.regressor(), logs, &options.preparation())?, model.nominal_parameters());
        Ok(log_check(model.regressor(), &records, &suspects, described.as_deref())?)
    })?;
    // A load is searched only on the last bodies of the chains.
    let linear = options.linear_model(model.regressor());
    let (map, described) = (model.standard_map(), model.nominal_parameters());
    let mass = |body: &usize| model.robot.link(model.body_links()[*body]).inertial.map_or(0.0, |of| of[9]);
    let bodies: Vec<(usize, f64)> = last_bodies(model).into_iter().map(|body| (body, mass(&body))).collect();
    found.look_for_load(&linear, records, (&map, described.as_deref()), &bodies)?;
    // Velocities and accelerations count as measured if a log has columns for them and the options do not replace these columns
    // by derivatives.
    let [velocity, acceleration] = logs.iter().fold([false; 2], |[v, a], log| {
        let [has_velocity, has_acceleration] = log.has_rates();
        [v || has_velocity, a || has_acceleration]
    });
    found.measured = Measured {
        velocity: velocity && signal.velocity != Velocity::Differentiated,
        acceleration: acceleration && signal.acceleration != Velocity::Differentiated,
    };
    let by_place = |names: &Option<NamePattern>| matches!(names, Some(NamePattern::Pattern(p)) if p.contains("{}"));
    found.is_by_place = by_place(&options.columns.position) || by_place(&options.columns.torque);
    let is_current = logs.iter().any(|log| log.effort_is().needs_gains());
    if let Some(gains) = gains.filter(|_| is_current) {
        found.gains_are(gains);
    }
    Ok(found)
}
