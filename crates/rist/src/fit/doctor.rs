//! Checks whether logs belong to the robot of a description, before anything is fitted.

use identification::estimate::options::Options;
use identification::estimate::passport::finding::{Fault, Finding};
use identification::estimate::passport::{Change, Measured, passport};
use identification::signals::records::{Records, SourceRecords};
use identification::signals::signal_options::Velocity;
use logs::{Effort, LogSource, Names};

pub use identification::estimate::ledger::claims_of_log;
pub use identification::estimate::passport::Passport;

pub use crate::request::DoctorRequest;

use crate::describe::model::Model;
use crate::error::Error;
use crate::fit::drive_gains::OWN_SCALE;
use crate::fit::gravity_direction::look_for_mount;
use crate::fit::load::last_bodies;
use crate::fit::normalised::look_for_shares;
use crate::fit::signal_sources::sources;

/// Looks at logs as an identification with these options would read them.
///
/// Currents become torques by the drive gains of the options, or else by those of the description. Where there are
/// none, currents are taken as they are, and the passport says which gains the description implies. Fails where a log
/// cannot be read or does not fit the robot.
pub fn examine(model: &Model, logs: &[LogSource], options: &Options) -> Result<Passport, Error> {
    let mut options = options.clone();
    let is_current = logs.iter().any(|log| log.effort_is().needs_gains());
    let are_known = options.transmission.drive_gains.is_some() || model.drive_gains().iter().all(Option::is_some);
    if is_current && options.transmission.drive_gains.is_none() {
        options.transmission.drive_gains = Some(model.drive_gains().into_iter().map(|g| g.unwrap_or(1.0)).collect());
    }
    let records = SourceRecords::new(model.regressor(), logs, &options.preparation())?;
    let gains = options.transmission.drive_gains.as_deref().filter(|_| are_known);
    let first = passport_of(model, logs, &records, gains, &options)?;
    // Columns that are no slopes are not used, and accuse nobody.
    let mut chosen = options.clone();
    let mut found = match sources(&first, &mut chosen).is_empty() {
        true => first,
        false => {
            let records = SourceRecords::new(model.regressor(), logs, &chosen.preparation())?;
            passport_of(model, logs, &records, gains, &chosen)?.with_columns_of(first)
        }
    };
    match are_known {
        false if logs.iter().any(|log| log.effort_is() == Effort::PositionError) => {
            found.efforts_are_position_errors(OWN_SCALE);
        }
        false if is_current => found.efforts_are_currents(),
        _ => {}
    }
    Ok(found)
}

impl DoctorRequest {
    /// The options with which logs are looked at.
    ///
    /// Fails where a gain is of no coordinate.
    pub fn options(&self, model: &Model) -> Result<Options, Error> {
        let mut options = self.options.clone().unwrap_or_default();
        if !self.gain.is_empty() {
            let mut all: Vec<f64> = model.drive_gains().into_iter().map(|gain| gain.unwrap_or(1.0)).collect();
            model.give_gains(&mut all, &self.gain)?;
            options.transmission.drive_gains = Some(all);
        }
        Ok(options)
    }
}

/// Says what undoes the findings: one request for all that were undone together, and one for each that other bodies explain
/// as well.
fn say_remedies(passport: &mut Passport, logs: &[LogSource], options: &Options, model: &Model) {
    let Some(columns) = logs.first().map(LogSource::names) else { return };
    let are_alike = logs.iter().all(|log| log.names() == columns);
    let regressor = model.regressor();
    let turns: Vec<bool> = (0..regressor.coordinates().len()).map(|k| !regressor.is_prismatic(k)).collect();
    let say =
        |changes: &[Change]| options.undoing(changes, &columns, &turns).filter(|_| are_alike)?.remedy_beside(options);
    let explanations = passport.findings.iter().map(|f| f.instead + 1).max().unwrap_or(0);
    for number in 0..explanations {
        let is_of = |f: &&Finding| f.instead == number && !f.undo.is_empty();
        let together = passport.findings.iter().filter(is_of).flat_map(|f| f.undo.iter().copied());
        let together = say(&together.collect::<Vec<Change>>());
        // Gains are those of a data sheet; the description tells them roughly.
        let is_said = |f: &&mut Finding| f.instead == number && !f.undo.is_empty() && f.fault != Fault::NoTorque;
        for finding in passport.findings.iter_mut().filter(is_said) {
            finding.remedy = together.clone().unwrap_or_else(|| BY_HAND.into());
        }
    }
    for explained in &mut passport.explained {
        explained.finding.remedy = say(&explained.finding.undo).unwrap_or_else(|| BY_HAND.into());
    }
}

/// What to do where no option says it.
const BY_HAND: &str = "write the log anew, with its columns in the order, sign and unit of the joints";

/// The passport of logs and their records. `gains`: the drive gains by which currents became torques, where they are
/// known. `options`: how the records were made.
pub fn passport_of<R: Records + ?Sized>(
    model: &Model,
    logs: &[LogSource],
    records: &R,
    gains: Option<&[f64]>,
    options: &Options,
) -> Result<Passport, Error> {
    let signal = &options.signal;
    let suspects: Vec<_> = logs.iter().flat_map(|log| log.report().suspect.clone()).collect();
    let look = |model: &Model| {
        let described = model.described_parameters();
        Ok(passport(model.regressor(), records, &suspects, described.as_deref())?)
    };
    let mut found: Passport = look(model)?;
    look_for_mount(model, records, &mut found, look)?;
    say_remedies(&mut found, logs, options, model);
    look_for_shares(model, options, &mut found, |options| {
        let (records, described) =
            (SourceRecords::new(model.regressor(), logs, &options.preparation())?, model.described_parameters());
        Ok(passport(model.regressor(), &records, &suspects, described.as_deref())?)
    })?;
    let linear = options.linear_model(model.regressor());
    let (map, described) = (model.standard_map(), model.described_parameters());
    let mass = |body: &usize| model.robot.link(model.body_links()[*body]).inertial.map_or(0.0, |of| of[9]);
    let bodies: Vec<(usize, f64)> = last_bodies(model).into_iter().map(|body| (body, mass(&body))).collect();
    found.look_for_load(&linear, records, (&map, described.as_deref()), &bodies)?;
    let [velocity, acceleration] = logs.iter().fold([false; 2], |[v, a], log| {
        let [has_velocity, has_acceleration] = log.has_rates();
        [v || has_velocity, a || has_acceleration]
    });
    found.measured = Measured {
        velocity: velocity && signal.velocity != Velocity::Differentiated,
        acceleration: acceleration && signal.acceleration != Velocity::Differentiated,
    };
    let by_place = |names: &Option<Names>| matches!(names, Some(Names::Pattern(p)) if p.contains("{}"));
    found.is_by_place = by_place(&options.columns.position) || by_place(&options.columns.torque);
    let is_current = logs.iter().any(|log| log.effort_is().needs_gains());
    if let Some(gains) = gains.filter(|_| is_current) {
        found.gains_are(gains);
    }
    Ok(found)
}
