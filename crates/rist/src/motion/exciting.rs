//! Searches a motion that makes the parameters of a model identifiable, and proves that this motion keeps its limits.
//!
//! A gap is a pair of bodies (or a body and a floor or wall) with a least distance (motion/kept_room.rs).

use std::path::Path;
use std::time::Duration;

use claims::LeftOut;
use claims::significant;
use experiments::excitation::artefact::MotionJoint;
use experiments::excitation::columns::visible_columns;
use experiments::excitation::criterion::SearchObjective;
use experiments::excitation::error_margins::ErrorMargins;
use experiments::excitation::fitting::Obligations;
use experiments::excitation::gap_proof::Gap;
use experiments::excitation::limits::{CoordinateLimits, LimitKind, motion_limits};
use experiments::excitation::margins::{self, Margins, with_margins};
use experiments::excitation::motion::{Motion, MotionShape};
use experiments::excitation::motion_claims::MotionClaims;
use experiments::excitation::no_motion::NoMotion;
use experiments::excitation::problem::Problem;
use experiments::excitation::proof::IdentifiedTorque;
use experiments::excitation::search::{StartResult, can_begin, search};
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
pub use crate::motion::excite_timing::default_period;
use crate::motion::excite_timing::timing;
use crate::motion::kept_room::{KeptRoom, keep_from_ends};
use crate::motion::known_torque::KnownTorque;
use crate::motion::no_motion_found::{Refusal, SearchedSpace};
use crate::motion::nominal::{nominal_friction, nominal_values, torque_left_out, torque_noise};
use crate::motion::proved_motion::{ProvedMotion, cost_note, proved};
use crate::request::ExciteRequest;

/// Reports the progress of a search. Arguments: number of finished starts, number of all starts, and a text with the criterion
/// (det^(1/p) or cond_fro) and the nearest limits.
pub type ExciteProgress<'a> = dyn Fn(usize, usize, &str) + Sync + 'a;

/// Longest duration of the proof after an interruption. The time is limited because the user waits for the end of the program.
pub(crate) const PROOF_AFTER_INTERRUPTION: Duration = Duration::from_secs(2);

/// Searches the motion with the largest determinant of the information (or the smallest condition number) of the regressor
/// columns, and proves its limits. If the proof fails, the certificate of the motion states it.
///
/// Links keep a default distance. If no motion is found with this distance, smaller distances are tried.
///
/// Fails if a number of the request gives no motion, or if no motion is found within the limits. If the user interrupts the
/// search, it continues with the best motion found; an interrupted proof fails.
pub fn excite(model: &Model, request: &ExciteRequest, progress: &ExciteProgress) -> Result<ExcitingMotion, Error> {
    request.check_motion()?;
    let steps = KeptRoom::steps(request);
    let mut floor_is_tried = true;
    for (i, kept) in steps.iter().enumerate() {
        // Without a floor that applies, the step without floor repeats the step with floor and the same distance.
        let is_last = i + 1 == steps.len();
        if !floor_is_tried && !kept.assumes_floor && !is_last && steps[..i].iter().any(|s| s.spacing == kept.spacing) {
            continue;
        }
        match searched(model, request, (kept, is_last), progress)? {
            SearchOutcome::Found(found) => return Ok(*found),
            SearchOutcome::NoPose { floor } => floor_is_tried = floor,
            SearchOutcome::Refused(refusal) => {
                let proves = |request: &ExciteRequest| {
                    let outcome = searched(model, request, (kept, true), &|_, _, _| ());
                    matches!(outcome, Ok(SearchOutcome::Found(found)) if found.proven)
                };
                return Err(refusal.with_remedies(request, proves));
            }
        }
    }
    Err(Error::new("no distance remains to be kept"))
}

/// The outcome of a search.
enum SearchOutcome {
    /// A motion was found.
    Found(Box<ExcitingMotion>),
    /// No pose keeps the distances between bodies. `floor`: whether a floor was assumed.
    NoPose { floor: bool },
    /// No motion was found, with the reason.
    Refused(Refusal),
}

/// Searches for a motion that keeps the distances `kept`. If smaller distances can be tried later, the search runs only if a
/// pose with these distances is found quickly.
fn searched(
    model: &Model,
    request: &ExciteRequest,
    (kept, is_last): (&KeptRoom, bool),
    progress: &ExciteProgress,
) -> Result<SearchOutcome, Error> {
    let friction = request.check_motion()?;
    let regressor = RegressorSlope::new(model)?;
    let conditions = Conditions::new(model, request, &regressor, kept);
    // If the conditions fail with the assumed floor, a body may be below this floor in every pose. So the next step has no
    // floor.
    if conditions.is_err() && kept.assumes_floor && !is_last {
        return Interruption::check().map(|()| SearchOutcome::NoPose { floor: true }).map_err(Error::from);
    }
    let (conditions, mut notes) = conditions?;
    let Conditions { names, limits, shape, known, surroundings, .. } = &conditions;
    let torque = known.nominal_enclosure(request.effort_share, limits);
    let barrier = known.torque_barrier(request.effort_share).filter(|_| torque.is_some());

    // The search uses the information of one sample, so the prior information is divided by the number of samples.
    let linear = LinearModel::new(&regressor, &friction, &[]);
    let columns = visible_columns(&linear, limits);
    let (prior, prior_notes) =
        request.after.as_ref().map_or((vec![], vec![]), |estimate| prior_rows(estimate, &linear));
    notes.extend(prior_notes);
    let played = (shape.period() * request.rate).round() * request.repetitions as f64;
    let prior_of_a_sample: Vec<f64> = prior.iter().map(|x| x / played.sqrt()).collect();
    let problem = Problem {
        regressor: &regressor,
        friction: &friction,
        limits,
        noise: &conditions.noise,
        aim: request.criterion,
        torque: barrier.as_ref(),
        columns: &columns,
        shape: *shape,
        samples: conditions.samples,
        surroundings: surroundings.some(),
        prior: &prior_of_a_sample,
    };
    if !is_last && problem.surroundings.is_some() && !can_begin(&problem, request.seed) {
        Interruption::check()?;
        return Ok(SearchOutcome::NoPose { floor: surroundings.floor().is_some() });
    }
    let report = |done: usize, found: Option<&StartResult>| {
        progress(done, request.starts, &progress_text(found, request.criterion, names, &surroundings.gaps))
    };
    let found = search(&problem, &request.search(), &report);
    notes.extend(cut_short(found.as_ref().map_or(0, Vec::len), request.starts)?);
    let found = match found {
        Ok(found) => found,
        Err(why) => return Ok(SearchOutcome::Refused(conditions.searched().refused(why, &problem))),
    };

    // Take the best motion whose limits are proven. If no motion is proven, take the best motion; its certificate then states
    // that the proof failed.
    let obligations = Obligations { limits, names, torque: torque.as_ref(), surroundings: surroundings.some() };
    let proved = proved(request, &problem, &obligations, *shape, found);
    Interruption::check()?;
    let Some(proved) = proved else {
        return Ok(SearchOutcome::Refused(conditions.searched().refused(NoMotion::NothingToTell, &problem)));
    };
    notes.extend(surroundings.note().into_iter().chain(cost_note(&proved, request.criterion)));
    notes.extend(kept.note(request, &surroundings.gaps));
    let ProvedMotion { motion, certificate, .. } = &proved;
    let noise = conditions.joint_noise(motion);
    let seen = visibility(&linear, motion, limits, &noise, &nominal_values(model, &linear), certificate, &prior);
    let margins = Margins::new(motion, certificate, &obligations, &conditions.errors, surroundings.mesh_error());
    Interruption::check()?;
    Ok(SearchOutcome::Found(Box::new(conditions.artefact(proved, noise, seen, margins, notes))))
}

/// The conditions of a search of a motion: model, limits, torques and bodies.
struct Conditions<'a> {
    model: &'a Model,
    request: &'a ExciteRequest,
    names: Vec<String>,
    /// The limits of the request. None of these limits is looser than the limit of the description.
    stated: Vec<CoordinateLimits>,
    /// Error margins of the robot (tracking, encoder zeros, bodies, payload).
    errors: ErrorMargins,
    /// The limits `stated`, reduced by the error margins.
    limits: Vec<CoordinateLimits>,
    shape: MotionShape,
    /// Number of instants per period that the search evaluates.
    samples: usize,
    identified: Option<IdentifiedTorque>,
    /// Noise (sigma) of a torque sample, N m (N), one value per coordinate.
    noise: Vec<f64>,
    known: KnownTorque<'a>,
    surroundings: RobotSurroundings,
    /// The requirements on space from the user, with the default distances.
    space: SpaceLimits,
    left_out: Vec<LeftOut>,
}

impl<'a> Conditions<'a> {
    fn searched(&self) -> SearchedSpace<'_> {
        let Conditions { model, request, names, limits, surroundings, .. } = self;
        SearchedSpace { model, request, names, limits, surroundings }
    }

    /// The conditions of a request, with notes on the conditions. Fails if they exclude every motion, or if a requirement of
    /// the user cannot be checked.
    fn new(
        model: &'a Model,
        request: &'a ExciteRequest,
        regressor: &RegressorSlope,
        kept: &KeptRoom,
    ) -> Result<(Conditions<'a>, Vec<String>), Error> {
        let names = regressor.coordinates().to_vec();
        let (mut stated, mut notes) = limits_and_notes(model, regressor, request)?;
        notes.extend(keep_from_ends(model, request, &mut stated));
        let of_model = |what| Error::new(format_args!("{}: {what}", model.path.display()));
        let errors = request.limits.as_ref().map(|limits| limits.margins.clone()).unwrap_or_default();
        let limits = with_margins(&errors, &names, &stated).map_err(of_model)?;
        let (shape, samples) = timing(request, &limits)?;
        let identified =
            request.after.as_ref().map(|estimate| identified_torque(model, &names, estimate)).transpose()?;
        let noise = noise(model, request, &names, &mut notes);

        // Known torques of the robot.
        let known = KnownTorque::new(model, identified.as_ref()).with_payload(model, errors.payload.as_ref())?;
        known.check_power(&names, &limits).map_err(of_model)?;
        known.check_friction(&names, &limits, request.effort_share).map_err(of_model)?;

        // Limits in space: distances between bodies, floor, walls.
        let (user, own) = (request.space(), SpaceLimits { spacing: kept.spacing, ..SpaceLimits::default() });
        let surroundings =
            RobotSurroundings::on_floor(model, &user, (Some(&own), kept.assumes_floor), &limits, &errors)?;
        // A floor that the user requires gets no default distance, so that a later check of the file has the same requirement.
        let spacing = own.spacing.filter(|_| user.floor.is_none());
        let space = SpaceLimits { spacing: spacing.or(user.spacing), ..user };
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
            space,
            left_out,
        };
        Ok((conditions, notes))
    }

    /// The noise of the torques, and the torque residuals that noise of the simulated encoders causes. Residuals of an earlier
    /// estimate already include the noise of the encoders.
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

    /// The content of motion.yaml: the motion with its limits, its certificate and the information on parameters.
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
        // An assumed floor is written into the file like a required floor.
        let floor = self.surroundings.floor().map(Floor::At).or(self.space.floor);
        let found = ExcitingMotion {
            checksum: Default::default(),
            model: self.model.reference.clone(),
            rate_hz: self.request.rate,
            period_s: self.shape.period(),
            blend_s: if let MotionShape::Fourier(series) = self.shape { Some(series.blend) } else { None },
            repetitions: self.request.repetitions,
            joints: motion.joints.iter().zip(&self.names).zip(&self.stated).map(joint).collect(),
            effort_share: self.request.effort_share,
            identified: self.identified.clone(),
            space: SpaceLimits { floor, ..self.space.clone() },
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
        ExcitingMotion { proven: found.claims().is_kept(), ..found }
    }
}

/// Fails before the search if a requirement of the user cannot be checked.
pub(crate) fn refuse_what_is_owed(model: &Model, left_out: &[LeftOut]) -> Result<(), Error> {
    let claims = MotionClaims { rows: &[], left_out, floor: None, lowest: None };
    match &claims.faults()[..] {
        [] => Ok(()),
        faults => Err(Error::new(format_args!("{}: {}", model.path.display(), faults.join("; ")))),
    }
}

/// A note if the search was interrupted. The amplitudes of the best motion found are then reduced to the limits, and the limits
/// are proved, unless the user interrupts the proof too. Fails if no motion was found.
fn cut_short(found: usize, starts: usize) -> Result<Option<String>, Error> {
    match (Interruption::take(), found) {
        (false, _) => Ok(None),
        (true, 0) => Err(Error::new("interrupted before there was a motion")),
        (true, _) => {
            Interruption::here().raise_within(PROOF_AFTER_INTERRUPTION);
            Ok(Some(format!("the search was interrupted: the best of {found} starts, of {starts}")))
        }
    }
}

/// The limits of the request, none looser than the description, and notes on these limits.
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

/// The torques of an estimate. Fails if the estimate was made with another model, or if it lacks parameters of this model.
pub(crate) fn identified_torque(
    model: &Model,
    names: &[String],
    estimate: &Estimate,
) -> Result<IdentifiedTorque, Error> {
    model.check_estimate(Path::new("the earlier estimate"), estimate)?;
    let described = nominal_friction(model);
    let friction = names.iter().zip(described).map(|(name, own)| identified_friction(estimate, name, own)).collect();
    Ok(IdentifiedTorque { parameters: model.values(estimate)?, friction })
}

/// Noise (sigma) of a torque sample, N m (N), one per coordinate: from the residuals of an earlier estimate, or else a share of
/// the effort limit.
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

fn progress_text(found: Option<&StartResult>, aim: SearchObjective, names: &[String], gaps: &[Gap]) -> String {
    let Some(found) = found else { return "no motion within the limits".into() };
    let value = match aim {
        SearchObjective::Determinant => format!("det^(1/p) {}", significant((-found.criterion).exp(), 4)),
        SearchObjective::Condition => format!("cond_fro {}", significant(found.criterion.exp(), 4)),
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
