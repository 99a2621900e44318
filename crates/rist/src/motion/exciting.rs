//! From a model to one motion that makes its parameters visible, within proved limits.

use std::path::Path;

use claims::LeftOut;
use claims::significant;
use clearance::shown_length::shown_length;
use experiments::excitation::artefact::MotionJoint;
use experiments::excitation::columns::visible_columns;
use experiments::excitation::criterion::Aim;
use experiments::excitation::error_margins::ErrorMargins;
use experiments::excitation::fitting::Obligations;
use experiments::excitation::gap_proof::Gap;
use experiments::excitation::ledger::MotionLedger;
use experiments::excitation::limits::{CoordinateLimits, LimitKind, motion_limits};
use experiments::excitation::margins::{self, Margins, with_margins};
use experiments::excitation::motion::{Motion, Shape};
use experiments::excitation::no_motion::NoMotion;
use experiments::excitation::problem::Problem;
use experiments::excitation::proof::IdentifiedTorque;
use experiments::excitation::search::{Found, search};
use experiments::excitation::space_limits::{Floor, SpaceLimits};
use experiments::excitation::visibility::{JointNoise, Visibility, visibility};
use experiments::simulate::setup::SimulationSetup;
use identification::estimate::artefact::Estimate;
use identification::signals::encoder_torque::encoder_torque;
use linear_model::linear_model::Model as LinearModel;
use linear_model::regressor::Regressor;

pub use experiments::excitation::artefact::ExcitingMotion;
pub use numerics::interruption::Interruption;

use crate::describe::adapters::regressor_slope::RegressorSlope;
use crate::describe::adapters::surroundings::RobotSurroundings;
use crate::describe::adapters::tape_dynamics::dynamics;
use crate::describe::model::Model;
use crate::error::Error;
use crate::motion::after_estimate::{identified_friction, prior_rows, residual_noise};
use crate::motion::described::{described_friction, described_values, torque_left_out, torque_noise};
pub use crate::motion::excite_timing::default_period;
use crate::motion::excite_timing::timing;
use crate::motion::known_torque::KnownTorque;
use crate::motion::proved_motion::{ProvedMotion, cost_note, proved};
use crate::request::ExciteRequest;

/// Arguments: starts done, starts, and a text of the criterion (det^(1/p), or cond_fro) and of the nearest limits.
pub type ExciteProgress<'a> = dyn Fn(usize, usize, &str) + Sync + 'a;

/// Searches for the motion with the greatest determinant of the information (or the least condition number) of the
/// columns of an identification, and proves its limits. The certificate of the motion says so if the proof fails.
///
/// Fails where a number of the request makes no motion, and where the limits leave none. If it is interrupted during
/// the search, it goes on with the best motion found; if during the proof, it fails.
pub fn excite(model: &Model, request: &ExciteRequest, progress: &ExciteProgress) -> Result<ExcitingMotion, Error> {
    let friction = request.check_motion()?;
    let regressor = RegressorSlope::new(model)?;
    let (conditions, mut notes) = Conditions::new(model, request, &regressor)?;
    let Conditions { names, limits, shape, known, surroundings, .. } = &conditions;
    let torque = known.described(request.effort_share, limits);
    let wall = known.wall(request.effort_share).filter(|_| torque.is_some());

    // The search.
    let linear = LinearModel::new(&regressor, &friction, &[]);
    let columns = visible_columns(&linear, limits);
    let (prior, told) = request.after.as_ref().map_or((vec![], vec![]), |estimate| prior_rows(estimate, &linear));
    notes.extend(told);
    let played = (shape.period() * request.rate).round() * request.repetitions as f64;
    let prior_of_a_sample: Vec<f64> = prior.iter().map(|x| x / played.sqrt()).collect();
    let problem = Problem {
        regressor: &regressor,
        friction: &friction,
        limits,
        noise: &conditions.noise,
        aim: request.criterion,
        torque: wall.as_ref(),
        columns: &columns,
        shape: *shape,
        samples: conditions.samples,
        surroundings: surroundings.some(),
        prior: &prior_of_a_sample,
    };
    let report = |done: usize, found: Option<&Found>| {
        progress(done, request.starts, &progress_text(found, request.criterion, names, &surroundings.gaps))
    };
    let found = search(&problem, &request.search(), &report);
    notes.extend(cut_short(found.as_ref().map_or(0, Vec::len), request.starts)?);
    let found = found.map_err(|why| conditions.refused(why))?;

    // The best motion that can be proved, or the best of all if none can; its certificate then says so.
    let obligations = Obligations { limits, names, torque: torque.as_ref(), surroundings: surroundings.some() };
    let proved = proved(request, &problem, &obligations, *shape, found);
    let proved = proved.ok_or_else(|| conditions.refused(NoMotion::NothingToTell))?;
    notes.extend(surroundings.note().into_iter().chain(cost_note(&proved, request.criterion)));
    Interruption::check()?;
    let ProvedMotion { motion, certificate, .. } = &proved;
    let noise = conditions.joint_noise(motion);
    let seen = visibility(&linear, motion, limits, &noise, &described_values(model, &linear), certificate, &prior);
    let margins = Margins::new(motion, certificate, &obligations, &conditions.errors, surroundings.mesh_error());
    Ok(conditions.artefact(proved, noise, seen, margins, notes))
}

/// What a motion of a model is searched under.
struct Conditions<'a> {
    model: &'a Model,
    request: &'a ExciteRequest,
    names: Vec<String>,
    /// The limits of the request within those of the description.
    stated: Vec<CoordinateLimits>,
    /// What the robot may be wrong by.
    errors: ErrorMargins,
    /// The stated limits, less what the errors take of them.
    limits: Vec<CoordinateLimits>,
    shape: Shape,
    /// Instants of a period at which the search looks.
    samples: usize,
    identified: Option<IdentifiedTorque>,
    /// N m (N) a torque sample, one per coordinate.
    noise: Vec<f64>,
    known: KnownTorque<'a>,
    surroundings: RobotSurroundings,
    left_out: Vec<LeftOut>,
}

impl<'a> Conditions<'a> {
    /// Of a request, with notes on them. Fails where they leave no motion, and where the user asked for something at which
    /// nobody could look.
    fn new(
        model: &'a Model,
        request: &'a ExciteRequest,
        regressor: &RegressorSlope,
    ) -> Result<(Conditions<'a>, Vec<String>), Error> {
        let names = regressor.coordinates().to_vec();
        let (stated, mut notes) = limits_and_notes(model, regressor, request)?;
        let of_model = |what| Error::new(format_args!("{}: {what}", model.path.display()));
        let errors = request.limits.as_ref().map(|limits| limits.margins.clone()).unwrap_or_default();
        let limits = with_margins(&errors, &names, &stated).map_err(of_model)?;
        let (shape, samples) = timing(request, &limits)?;
        let identified =
            request.after.as_ref().map(|estimate| identified_torque(model, &names, estimate)).transpose()?;
        let noise = noise(model, request, &names, &mut notes);

        // Known torques.
        let known = KnownTorque::new(model, identified.as_ref()).with_payload(model, errors.payload.as_ref())?;
        known.check_power(&names, &limits).map_err(of_model)?;
        known.check_friction(&names, &limits, request.effort_share).map_err(of_model)?;

        // Places that bodies may reach.
        let surroundings = RobotSurroundings::new(model, &request.space(), None, &limits, &errors)?;
        let mut left_out = surroundings.left_out.clone();
        left_out.extend(torque_left_out(model, known.enclosure.is_some(), &names, &limits, request.limits.as_ref()));
        refuse_what_is_owed(model, &left_out)?;
        left_out.push(LeftOut::approach());
        left_out.extend(margins::left_out(&errors));
        let conditions = Conditions {
            model,
            request,
            names,
            stated,
            errors,
            limits,
            shape,
            samples,
            identified,
            noise,
            known,
            surroundings,
            left_out,
        };
        Ok((conditions, notes))
    }

    /// The noise of the torques, and what encoders as a simulation assumes them add to the residuals of the motion. The
    /// residuals of an earlier estimate already include the encoders.
    fn joint_noise(&self, motion: &Motion) -> JointNoise {
        let torque = self.noise.clone();
        match &self.known.parameters {
            Some(parameters) if self.request.after.is_none() => {
                let dynamics = dynamics(self.model, parameters.clone());
                let sensing = SimulationSetup::for_robot(&self.model.robot, dynamics.as_ref()).sensing;
                let encoders = encoder_torque(dynamics.as_ref(), &motion.reference(), &sensing.position_deviation());
                JointNoise { torque, encoders }
            }
            _ => JointNoise::of_torques(torque),
        }
    }

    /// motion.yaml: the request, the motion, and what is known of it.
    fn artefact(
        &self,
        proved: ProvedMotion,
        noise: JointNoise,
        seen: Visibility,
        margins: Margins,
        notes: Vec<String>,
    ) -> ExcitingMotion {
        let ProvedMotion { motion, certificate, kept_share, .. } = proved;
        let joint = |((x, name), limits): ((&Vec<f64>, &String), &CoordinateLimits)| {
            MotionJoint::new(name.clone(), &motion.shape, x, limits.clone())
        };
        let asked = self.request.space();
        // The floor of the base stands in the file as one that was asked for.
        let floor = self.surroundings.floor().map(Floor::At).or(asked.floor);
        let found = ExcitingMotion {
            seal: Default::default(),
            model: self.model.reference.clone(),
            rate_hz: self.request.rate,
            period_s: self.shape.period(),
            blend_s: if let Shape::Fourier(series) = self.shape { Some(series.blend) } else { None },
            repetitions: self.request.repetitions,
            joints: motion.joints.iter().zip(&self.names).zip(&self.stated).map(joint).collect(),
            effort_share: self.request.effort_share,
            identified: self.identified.clone(),
            space: SpaceLimits { floor, ..asked },
            aim: self.request.criterion,
            determinant: seen.determinant,
            condition_number: seen.condition_number,
            kept_share: Some(kept_share),
            torque_noise: noise.torque,
            encoder_noise: noise.encoders,
            proven: false,
            notes,
            left_out: Some(self.left_out.clone()),
            lowest: self.surroundings.lowest(&motion),
            margins: Some(margins),
            certificate,
            parameters: seen.parameters,
        };
        ExcitingMotion { proven: found.ledger().is_kept(), ..found }
    }

    /// Why there is no motion, and what to do.
    fn refused(&self, why: NoMotion) -> Error {
        let (path, names) = (self.model.path.display(), &self.names);
        match why {
            NoMotion::AllLocked => {
                Error::new(format_args!("{path}: every coordinate is locked: unlock one in the limits file"))
            }
            NoMotion::NothingToTell => Error::new(format_args!(
                "{path}: no motion of the coordinates that are not locked tells any parameter: unlock more of them"
            )),
            NoMotion::TooSmall { coordinate, limit, swing, speed } => {
                let slides = self.model.regressor().is_prismatic(coordinate);
                let unit = |kind: LimitKind| kind.unit(slides);
                Error::new(format_args!(
                    "{path}: no motion found tells the parameters apart: {}, the slowest, swings by {swing:.1e} {} with {speed:.1e} \
                     {} at most; nearest is its limit of {limit}: raise it, choose another [period], or lock the coordinate",
                    names[coordinate],
                    unit(LimitKind::Position),
                    unit(LimitKind::Velocity)
                ))
            }
            NoMotion::TooWeak { coordinate, limit, share } => Error::new(format_args!(
                "{path}: no motion keeps the {limit} limit of {}: even a tiny one takes {:.0} % of what is allowed; the \
                 limits of position leave no pose that is light enough, the {limit} limit or [effort_share] is too small, \
                 or the inertial parameters are too great",
                names[coordinate],
                100.0 * share
            )),
            NoMotion::TooNarrow { gap, room } => self.too_narrow(&self.surroundings.gaps[gap], room),
        }
    }

    /// Refuses a search whose best motion has so much room, m, at a gap.
    fn too_narrow(&self, gap: &Gap, room: f64) -> Error {
        let tight = self.surroundings.tight(&self.limits);
        let room = if room < 0.0 {
            format!("the best found is {} m short of it", shown_length(-room))
        } else {
            format!("the best found has {room:.1e} m to spare, and a search needs more")
        };
        let pair = |(subject, most, bound): &(String, f64, f64)| {
            format!("{subject}: at most {} m of {} m", shown_length(*most), shown_length(*bound))
        };
        let pairs: Vec<String> = tight.pairs.iter().map(pair).collect();
        let few = "; over 1000 poses these pairs have too little room: ";
        let pairs = if pairs.is_empty() { String::new() } else { [few, &pairs.join("; ")].concat() };
        let works = Some(tight.works).filter(|works| *works > 0.0 && works.is_finite());
        let works =
            works.map_or(String::new(), |w| format!("; distance: {} has room at one of these poses", shown_length(w)));
        let sign = match gap.limit {
            LimitKind::Distance => "; for links that may meet, sign the pair: accept: [[LINK, LINK, REASON]]",
            _ => "",
        };
        Error::new(format_args!(
            "{}: no motion keeps the {}: {room}{pairs}{works}; the limits of position leave no place that is free, or \
             the limit is too tight{sign}",
            self.model.path.display(),
            gap.in_words()
        ))
    }
}

/// Fails where the user asked for something at which nobody could look, before a search is lost to it.
pub(crate) fn refuse_what_is_owed(model: &Model, left_out: &[LeftOut]) -> Result<(), Error> {
    let ledger = MotionLedger { rows: &[], left_out, floor: None, lowest: None };
    match &ledger.faults()[..] {
        [] => Ok(()),
        faults => Err(Error::new(format_args!("{}: {}", model.path.display(), faults.join("; ")))),
    }
}

/// A note where the search was interrupted. The best motion found is then fitted and proved, unless that is interrupted
/// too. Fails where none was found.
fn cut_short(found: usize, starts: usize) -> Result<Option<String>, Error> {
    match (Interruption::take(), found) {
        (false, _) => Ok(None),
        (true, 0) => Err(Error::new("interrupted before there was a motion")),
        (true, _) => Ok(Some(format!("the search was interrupted: the best of {found} starts, of {starts}"))),
    }
}

/// The limits of the request within those of the description, and notes on them.
fn limits_and_notes(
    model: &Model,
    regressor: &RegressorSlope,
    request: &ExciteRequest,
) -> Result<(Vec<CoordinateLimits>, Vec<String>), Error> {
    let described: Vec<robot::Limits> = model.robot.coordinates.iter().map(|c| c.limits).collect();
    let is_prismatic = |k: usize| regressor.is_prismatic(k);
    let file = request.limits.clone().unwrap_or_default();
    let (limits, mut notes) = motion_limits(regressor.coordinates(), is_prismatic, &described, &file)
        .map_err(|what| Error::new(format_args!("{}: {what}", model.path.display())))?;
    let soft = model.robot.notes.iter().filter(|note| note.text.starts_with("has soft limits"));
    notes.extend(soft.map(|note| format!("{} {}", note.subject, note.text)));
    Ok((limits, notes))
}

/// Takes the torques from an estimate. Fails where it is of another model, or lacks parameters of this one.
pub(crate) fn identified_torque(
    model: &Model,
    names: &[String],
    estimate: &Estimate,
) -> Result<IdentifiedTorque, Error> {
    model.check_estimate(Path::new("the earlier estimate"), estimate)?;
    let described = described_friction(model);
    let friction = names.iter().zip(described).map(|(name, own)| identified_friction(estimate, name, own)).collect();
    Ok(IdentifiedTorque { parameters: model.values(estimate)?, friction })
}

/// Noise of a torque sample, N m (N), one per coordinate: from an estimate's residuals, or a share of the effort limit.
fn noise(model: &Model, request: &ExciteRequest, names: &[String], notes: &mut Vec<String>) -> Vec<f64> {
    let mut assumed = vec![];
    let shares = torque_noise(model, request.noise, &mut assumed);
    let residual =
        |name: &String| request.after.as_ref().and_then(|estimate| residual_noise(estimate, name, request.rate));
    let found: Vec<Option<f64>> = names.iter().map(residual).collect();
    if found.iter().any(Option::is_none) {
        notes.extend(assumed);
    }
    found.into_iter().zip(shares).map(|(residual, share)| residual.unwrap_or(share)).collect()
}

fn progress_text(found: Option<&Found>, aim: Aim, names: &[String], gaps: &[Gap]) -> String {
    let Some(found) = found else { return "no motion within the limits".into() };
    let value = match aim {
        Aim::Determinant => format!("det^(1/p) {}", significant((-found.criterion).exp(), 4)),
        Aim::Condition => format!("cond_fro {}", significant(found.criterion.exp(), 4)),
    };
    let (room, k, limit): (f64, usize, LimitKind) = found.room;
    let torque = found.torque.map(|(share, k, limit)| {
        let what = if limit == LimitKind::Power { "power" } else { "torque" };
        format!(", {what} at most {:.0} % of what it may be ({})", 100.0 * share, names[k])
    });
    let nearest = found.nearest.map(|(room, gap)| format!(", {:.3} m above the {}", room, gaps[gap].in_words()));
    format!(
        "{value}, least room {:.2} % ({limit} of {}){}{}",
        100.0 * room,
        names[k],
        torque.unwrap_or_default(),
        nearest.unwrap_or_default()
    )
}
