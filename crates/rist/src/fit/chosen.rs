//! What an identification decides where its user says nothing, each with the figures behind it and what pins it.
//!
//! | what | is decided by |
//! |---|---|
//! | source of velocity and acceleration | whether the columns of the log are the slopes of positions and velocities |
//! | rotor inertia of a URDF, which cannot say | the error on parts of the logs, each predicted from the others; or its own deviation |
//! | delay of the torques | that error, where the passport sees one |
//! | friction of single joints | the same ([`crate::fit::friction`]) |

use claims::Claim;
use identification::estimate::delay::{Delay, estimate_delay};
use identification::estimate::digits::significant;
use identification::estimate::held_out::cross_validate;
use identification::estimate::identify::Fit;
use identification::estimate::ledger::hypotheses::{Open, Tested, Tilt as TiltTorque};
use identification::estimate::ledger::topics::{DELAY_TAKEN, ROTORS_TAKEN, mended};
use identification::estimate::options::Options;
use identification::estimate::passport::Passport;
use identification::estimate::passport::finding::Fault;
use identification::estimate::rotors::WithRotors;
use identification::rows::observation::{Beside, Observation};
use identification::signals::records::SourceRecords;
use linear_model::description_options::RotorInertias;
use linear_model::unit::Unit;
use logs::LogSource;
use robot::value::CoordinateId;
use robot::{Format, RotorInertia};

use crate::describe::description::set_rotor_inertias;
use crate::describe::model::Model;
use crate::error::Error;
use crate::fit::doctor::passport_of;
use crate::fit::mount::Tilt;
use crate::fit::signal_sources::sources;
use crate::request::SamplesRequest;

/// Error on parts left out over that without a choice, below which the choice is taken.
pub(crate) const WORTHWHILE_ERROR_RATIO: f64 = 0.97;
/// With errors below this nothing is left to explain, and a difference is rounding.
pub(crate) const NEGLIGIBLE_ERROR: f64 = 1e-3;

/// What was decided.
#[derive(Default)]
pub(crate) struct Chosen<'a> {
    /// The model with rotor inertias, where they predict better.
    pub model: Option<Model>,
    /// The delay that was found.
    pub delay: Option<Delay>,
    /// A sentence on each decision.
    pub sentences: Vec<String>,
    /// What was mended, with the errors without it and with it.
    pub mended: Vec<Claim>,
    /// The logs as they were read for it, where the model is the one given.
    pub looked: Option<Looked<'a>>,
}

/// Logs that were read, and what they were read with.
pub(crate) struct Looked<'a> {
    /// The options that they were read with: with others they must be read anew.
    pub options: Options,
    pub records: SourceRecords<'a>,
    pub passport: Passport,
    /// The rows, where they were made.
    pub rows: Option<Observation>,
    /// The rows with the columns of rotor inertias, where they were made.
    with_rotors: Option<WithRotors>,
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

    /// The same, read anew only where they were read with other options.
    ///
    /// Fails where a log cannot be read.
    pub(crate) fn again(
        before: Option<Looked<'a>>,
        model: &'a Model,
        logs: &'a [LogSource],
        options: &Options,
    ) -> Result<Looked<'a>, Error> {
        match before.filter(|looked| looked.options == *options) {
            Some(looked) => Ok(looked),
            None => Looked::of(model, logs, options),
        }
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

/// Decides what the request leaves open, and puts it into the options.
///
/// Fails where a log cannot be read.
pub(crate) fn choose<'a>(
    model: &'a Model,
    logs: &'a [LogSource],
    request: &SamplesRequest,
    options: &mut Options,
) -> Result<Chosen<'a>, Error> {
    let mut chosen = Chosen::default();
    // Nothing can be decided by torques while their gains are unknown.
    let is_current = logs.iter().any(|log| log.effort_is().needs_gains());
    if is_current && options.transmission.drive_gains.is_none() {
        return Ok(chosen);
    }
    // Another source of velocity changes the rows, so the log is looked at again.
    let mut looked = Looked::of(model, logs, options)?;
    chosen.sentences.extend(sources(&looked.passport, options));
    if looked.options != *options {
        looked = Looked::of(model, logs, options)?;
    }
    // The delay comes last: it is looked for with the model that will be used.
    let may_be_late = request.rows.signals.delay.is_none() && options.signal.delay == 0.0;
    if let Some((rotating, sentence)) = rotors(model, &mut looked, options)? {
        chosen.mended.push(mended(ROTORS_TAKEN, &sentence));
        chosen.sentences.push(sentence);
        if may_be_late {
            let passport = Looked::of(&rotating, logs, options)?.passport;
            chosen.take(late(&rotating, logs, &passport, options)?);
        }
        chosen.model = Some(rotating);
        return Ok(chosen);
    }
    if may_be_late {
        chosen.take(late(model, logs, &looked.passport, options)?);
    }
    chosen.looked = Some(looked);
    Ok(chosen)
}

impl Chosen<'_> {
    fn take(&mut self, found: Option<(Delay, String)>) {
        if let Some((delay, sentence)) = found {
            self.delay = Some(delay);
            self.mended.push(mended(DELAY_TAKEN, &sentence));
            self.sentences.push(sentence);
        }
    }
}

/// Whether rotor inertias are to be asked for: the model is of a URDF, which cannot say them, or of an MJCF, which does not
/// need to, and nobody decided.
fn may_lack_rotors(model: &Model) -> bool {
    let may_say_none = model.robot.format != Format::Complete;
    let is_pinned = model.description.as_ref().is_some_and(|d| d.rotor_inertia.is_some());
    let lacks = model.robot.links.iter().all(|link| link.joint.rotor_inertia == RotorInertia::Absent);
    may_say_none && !is_pinned && lacks
}

/// Why a model lacks rotor inertias.
fn lack(model: &Model) -> &'static str {
    if model.robot.format == Format::Urdf { "a URDF cannot say" } else { "the description does not give" }
}

/// The model with rotor inertias where a URDF lacks them and parts left out are predicted better with them.
/// Where they do not, the rows that were made for it are kept.
fn rotors(model: &Model, looked: &mut Looked<'_>, options: &Options) -> Result<Option<(Model, String)>, Error> {
    if !may_lack_rotors(model) {
        return Ok(None);
    }
    let made = match looked.with_rotors.take() {
        None => WithRotors::of_records(model.regressor(), &looked.records, options)?,
        made => made,
    };
    let Some(rows) = made else { return Ok(None) };
    let (without, with) = rows.errors(model.regressor(), options);
    if without < NEGLIGIBLE_ERROR || with > WORTHWHILE_ERROR_RATIO * without {
        looked.rows = Some(rows.without(model.regressor(), options));
        return Ok(None);
    }
    let rotating = rotating(model)?;
    let lack = lack(model);
    let sentence = format!(
        "rotor inertias are among the parameters, which {lack}: parts left out are predicted with an error of \
         {with:.4} instead of {without:.4} ([rotor_inertia=none] leaves them out)"
    );
    Ok(Some((rotating, sentence)))
}

/// The model with rotor inertias of its actuated joints.
fn rotating(model: &Model) -> Result<Model, Error> {
    model.changed(
        |robot| set_rotor_inertias(robot, RotorInertias::Actuated),
        |description| description.rotor_inertia = Some(RotorInertias::Actuated),
    )
}

/// With the torques by which a tilt of the mount shows, and the rotors of which nobody spoke.
///
/// `fitted`: base parameters, to which the described bodies are brought by the column that each has its name from.
pub(crate) fn with_open<T>(model: &Model, fitted: Option<&[f64]>, look: impl FnOnce(Open) -> T) -> T {
    let (of, described) = (&model.parameters, model.described_parameters().unwrap_or_default());
    let brought = of.base.iter().zip(fitted.unwrap_or_default().iter().zip(&described));
    let changes: Vec<_> = brought.map(|(base, (x, described))| (of.standard[base.column], x - described)).collect();
    let tilts = Tilt::both(&model.robot, &changes);
    let torques: Vec<_> = tilts.iter().map(|(axis, tilt)| (*axis, |q: &[f64]| tilt.torques(q))).collect();
    let torques: Vec<(usize, TiltTorque)> =
        torques.iter().map(|(axis, torque)| (*axis, torque as TiltTorque)).collect();
    look(Open { tilts: &torques, rotors: &open_rotors(model) })
}

/// The coordinates whose motor may have a rotor of which nobody spoke.
fn open_rotors(model: &Model) -> Vec<usize> {
    let is_actuated = |k: &usize| model.robot.joint_of(CoordinateId(*k)).is_some();
    let count = if may_lack_rotors(model) { model.robot.n_coordinates() } else { 0 };
    (0..count).filter(is_actuated).collect()
}

/// The model with rotor inertias where these faults of a fit tell one, too small for the error to tell it by far; and a
/// sentence on it.
pub(crate) fn told_rotors(model: &Model, fit: &Fit, faults: &[Tested]) -> Result<Option<(Model, String)>, Error> {
    let told = faults.iter().filter_map(|f| Some((f.told_rotor()?, f)));
    let Some((k, rotor)) = told.max_by(|a, b| a.1.value.total_cmp(&b.1.value)) else { return Ok(None) };
    let joint = &fit.estimate.joints[k];
    let unit = if joint.unit == Unit::TORQUE { "kg m^2" } else { "kg" };
    let (value, deviation) = (significant(rotor.value), significant(rotor.deviation));
    let sentence = format!(
        "rotor inertias are among the parameters, which {}: that of {} is told with {value} +- {deviation} {unit} \
         ([rotor_inertia=none] leaves them out)",
        lack(model),
        joint.coordinate
    );
    Ok(Some((rotating(model)?, sentence)))
}

/// The delay that the passport sees, where parts left out are predicted better with it.
fn late(
    model: &Model,
    logs: &[LogSource],
    passport: &Passport,
    options: &mut Options,
) -> Result<Option<(Delay, String)>, Error> {
    if !passport.findings.iter().any(|f| matches!(f.fault, Fault::Delay(_))) {
        return Ok(None);
    }
    let error = |options: &Options| -> Result<f64, Error> {
        let linear = options.linear_model(model.regressor());
        let records = SourceRecords::new(model.regressor(), logs, &options.preparation())?;
        let observation = Observation::of_records(&linear, &records, None)?;
        Ok(cross_validate(&linear, &observation, options.weights).total)
    };
    let mut late = options.clone();
    // A search that ends nowhere leaves the torques as they are, and the passport says so.
    let Ok(found) = found_delay(model, logs, &mut late) else { return Ok(None) };
    let (without, with) = (error(options)?, error(&late)?);
    if with > WORTHWHILE_ERROR_RATIO * without {
        return Ok(None);
    }
    *options = late;
    let sentence = format!(
        "the torques come {:.1} ms later than the positions, and are taken back: parts left out are predicted with an error \
         of {with:.4} instead of {without:.4} ([delay=0] leaves them)",
        1e3 * found.seconds
    );
    Ok(Some((found, sentence)))
}

/// The delay with the smallest residual, put into the options.
pub(crate) fn found_delay(model: &Model, logs: &[LogSource], options: &mut Options) -> Result<Delay, Error> {
    let delay = estimate_delay(model.regressor(), logs, options)?;
    if delay.at_the_end {
        return Err(Error::verdict(format_args!(
            "delay {:.4} s: residual {} {:.4}, without it {:.4}; the search ends there, but the \
             residual still falls: the delay is longer, or no delay explains these logs; look at units, signs and \
             drive gains, or give the delay",
            delay.seconds,
            delay.rows(),
            delay.residual,
            delay.residual_without
        )));
    }
    options.signal.delay = delay.seconds;
    Ok(delay)
}
