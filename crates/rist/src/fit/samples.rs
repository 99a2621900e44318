//! Identifies parameters from logs, step by step: gains, delay, friction, fit, bodies that can exist, load, remarks.

use identification::estimate::consistent::{bodies, identify_consistent};
use identification::estimate::essential::keep_essential;
use identification::estimate::identify::Fit;
use identification::estimate::impossible::impossible;
use identification::estimate::ledger::hypotheses::Tested;
use identification::estimate::ledger::widen_by_unknowns;
use identification::estimate::logs_left_out::{LogLeftOut, logs_left_out, sentence as of_left_out};
use identification::estimate::options::Options;
use identification::estimate::passport::Passport;
use identification::estimate::remarks::outgrown;
use identification::estimate::standing_torque::{farther_at_rest, offset_beside_weight};
use identification::estimate::verdict::{BodiesEvidence, Evidence, Prediction, Trust, Verdict};
use linear_model::pseudo_inertia::Ten;
use logs::LogSource;
use robot::{Inertial, LinkId};

use crate::describe::model::Model;
use crate::error::Error;
use crate::fit::candidates::delay::delay;
use crate::fit::candidates::friction::{asked_friction, joint_friction};
use crate::fit::candidates::gains::gains;
use crate::fit::candidates::mount::mount;
use crate::fit::candidates::possible_bodies::{described_error, possible_bodies};
use crate::fit::candidates::rates::rates;
use crate::fit::candidates::rotors::{rotors, significant_rotors};
use crate::fit::candidates::unknowns::Unknowns;
use crate::fit::drive_gains::{OWN_SCALE, gain_remark, is_own_scale};
use crate::fit::load::{Load, Scales, load};
pub use crate::fit::search::Decisions;
use crate::fit::search::{Asked, Candidate, Fitted, Kept, Searched, Tried, search};
use crate::fit::unsure_torques::{Noise, UnsureTorques};
use crate::request::Request;
pub use crate::request::{IdentifyRequest, SamplesRequest};
pub use claims::Claim;
use identification::estimate::artefact::Estimate;

/// The outcome of an identification.
pub struct Identification {
    /// The model that was used, where it is not the one given: with the rotor inertias that its URDF cannot say.
    pub model: Option<Model>,
    /// Values, intervals, residuals and remarks.
    pub estimate: Estimate,
    /// What was decided beside the fit.
    pub decided: Decisions,
    /// The load of the loaded logs.
    pub load: Option<Load>,
    /// The bodies, where only those that can exist were asked for.
    pub bodies: Option<Bodies>,
    /// Whether the logs belong to the description.
    pub passport: Passport,
    /// |tau - W X| / |tau| of the description with fitted friction; `None` where it has no inertials.
    pub described: Option<f64>,
    /// |tau - W X| / |tau| of least squares on parts of the logs, each predicted from the others.
    pub held_out: Option<f64>,
    /// Each of several logs, predicted by parameters from the others.
    pub logs_left_out: Vec<LogLeftOut>,
    /// The evidence for and against the bodies.
    pub bodies_evidence: Option<BodiesEvidence>,
    /// What they follow from.
    pub(crate) unsure: UnsureTorques,
    /// Faults of the logs, each tested as one unknown more.
    pub faults: Vec<Tested>,
    /// The base parameters of the description; `None` where it has no inertials.
    pub described_parameters: Option<Vec<f64>>,
}

impl Identification {
    /// The model that was used, where `given` was given.
    pub fn used<'a>(&'a self, given: &'a Model) -> &'a Model {
        self.model.as_ref().unwrap_or(given)
    }

    /// With what was found of unknowns, which deviations and remarks tell from now on.
    fn with_unknowns(mut self, mut unknowns: Unknowns) -> Identification {
        widen_by_unknowns(&mut self.estimate, &unknowns.steps);
        self.estimate.remarks.splice(..0, unknowns.remarks);
        self.decided.unknowns.append(&mut unknowns.steps);
        Identification { model: self.model.or(unknowns.model), ..self }
    }

    /// Says that torques are up to the gains of servos, and holds nothing against a description in N m.
    fn in_own_scale(mut self) -> Identification {
        self.passport.efforts_are_position_errors(OWN_SCALE);
        self.estimate.remarks.insert(0, OWN_SCALE.into());
        if let Some(bodies) = &mut self.bodies {
            bodies.refusal = Some(format!("{OWN_SCALE}: no body in kg follows without [gain]"));
        }
        if let Some(evidence) = &mut self.bodies_evidence {
            evidence.refusal = self.bodies.as_ref().and_then(|bodies| bodies.refusal.clone());
            evidence.masses.clear();
        }
        Identification { described: None, described_parameters: None, ..self }
    }

    /// Whether to trust the estimate. If the answer is no, the estimate says so from now on. `prediction`: of logs that
    /// were not fitted, where there are some.
    pub(crate) fn judge(&mut self, prediction: Prediction) -> Verdict {
        self.estimate.refusal = Vec::new();
        let parts_are_new = self.passport.visited.has_new_parts();
        let verdict = Verdict::of(&Evidence {
            estimate: &self.estimate,
            passport: Some(&self.passport),
            described: self.described,
            described_parameters: self.described_parameters.as_deref(),
            total: self.estimate.total,
            is_of_fit: true,
            prediction: Prediction { held_out: self.held_out, parts_are_new, ..prediction },
            bodies: self.bodies_evidence.as_ref(),
            opens_in_any_motion: self.unsure.opens_in_any_motion,
            faults: &self.faults,
            mended: &self.decided.mended,
        });
        if verdict.trust == Trust::No {
            self.estimate.refusal.clone_from(&verdict.reasons);
        }
        verdict
    }
}

/// Bodies and rotors that can exist.
pub struct Bodies {
    /// XX XY XZ YY YZ ZZ MX MY MZ M about the frame of each link that has inertials.
    pub links: Vec<(LinkId, Ten)>,
    /// Rotor inertia of each coordinate, kg m^2 (kg); zero where the model has none.
    pub armatures: Vec<f64>,
    /// Why they must not be used. Nothing is written into a simulator's file while there is a reason.
    pub refusal: Option<String>,
}

/// Identifies the base parameters and the friction of a robot from its logs.
///
/// Fails where the logs do not fit the robot, and with a verdict where the data leave a gain or the delay open. A
/// parameter that the data do not determine is no failure: its status says so.
pub fn identify(model: &Model, logs: &[LogSource], request: &IdentifyRequest) -> Result<Identification, Error> {
    identify_loaded(model, logs, &[], request)
}

/// As [`identify`], with the load of logs of the same robot.
///
/// Fails as [`identify`] does, and where the load is on no link.
pub fn identify_loaded(
    model: &Model,
    logs: &[LogSource],
    loaded: &[LogSource],
    request: &IdentifyRequest,
) -> Result<Identification, Error> {
    request.check()?;
    let kept = match (request.consistent, request.free_bodies) {
        (true, true) => return Err(Error::new("[free_bodies=true] and [consistent=true] exclude one another")),
        (true, false) => Kept::Consistent,
        (false, true) => Kept::Free,
        (false, false) => Kept::All,
    };
    identify_kept(model, logs, loaded, &request.samples, kept)
}

/// As [`identify_loaded`], with only the parameters that the data need; the others are zero. Bodies need all of theirs, so
/// there are none.
///
/// Fails as [`identify`] does.
pub fn identify_essential(
    model: &Model,
    logs: &[LogSource],
    loaded: &[LogSource],
    request: &SamplesRequest,
) -> Result<Identification, Error> {
    request.check()?;
    identify_kept(model, logs, loaded, request, Kept::Essential)
}

/// What is tried where nobody decided, in this order.
const CANDIDATES: [Candidate; 9] =
    [gains, rates, rotors, delay, asked_friction, significant_rotors, mount, joint_friction, possible_bodies];

fn identify_kept(
    model: &Model,
    logs: &[LogSource],
    loaded: &[LogSource],
    request: &SamplesRequest,
    kept: Kept,
) -> Result<Identification, Error> {
    let unknowns = (!request.unknowns.is_empty()).then(|| Unknowns::find(model, logs, request)).transpose()?;
    let model = unknowns.as_ref().and_then(|unknowns| unknowns.model.as_ref()).unwrap_or(model);
    let request = unknowns.as_ref().map_or(request, |unknowns| &unknowns.request);
    let options = Options { model: model.robot.name.clone(), ..request.options() };
    let is_own_scale = is_own_scale(model, logs, &request.gain, &options)?;
    let searched =
        search(model, Asked { logs, request, kept }, options, &CANDIDATES, &|tried: Tried<'_>| tried.finish())?;
    let Searched { model: changed, options, found: decided, end: (passport, Fitted { mut fit, faults }) } = searched;
    let model = changed.as_ref().unwrap_or(model);
    let gains = decided.gains.as_ref();
    let link = request.loaded_link.as_deref();
    let scales = Scales { gains, faults: &faults, passport: &passport };
    let load = (!loaded.is_empty()).then(|| load(model, link, &fit, loaded, &options, &scales)).transpose()?;
    let (noise, described_parameters) = (Noise::of(&fit), model.described_parameters());
    let described = described_parameters.as_ref().map(|x| described_error(model, &fit, &options, x));
    if kept == Kept::Essential {
        keep_essential(model.regressor(), &mut fit, &options);
    }
    let held_out = fit.estimate.cross_validation;
    let logs_left_out = left_out(model, &fit, &options, described_parameters.as_deref());
    let kept = if decided.possible_bodies { Kept::Consistent } else { kept };
    let mut found = found_bodies(model, fit, kept, &options)?;
    if decided.possible_bodies {
        // Nobody asked for a file of bodies.
        (found.bodies, found.evidence, found.outgrown) = (None, None, Vec::new());
    }

    // The remarks, and the gains that the estimate stands on.
    let fingerprint = Some(model.reference.fingerprint.clone());
    let mut estimate = Estimate { fingerprint, description: model.description.clone(), ..found.estimate };
    estimate.remarks.extend(gains.map(|found| gain_remark(model, logs, &request.gain, found)));
    let unsure = UnsureTorques::widening(&mut estimate, noise, gains, &faults, model, &options);
    estimate.doubts.extend(impossible(&model.standard_map(), &estimate));
    estimate.remarks.splice(..0, decided.sentences.clone());
    let outgrown = found.outgrown.into_iter().filter(|_| !is_own_scale);
    estimate.remarks.extend(of_left_out(&logs_left_out, &estimate.logs).into_iter().chain(outgrown));
    widen_by_unknowns(&mut estimate, &decided.unknowns);
    let found = Identification {
        model: changed,
        estimate,
        decided,
        load,
        bodies: found.bodies,
        passport,
        described,
        held_out,
        logs_left_out,
        bodies_evidence: found.evidence,
        unsure,
        faults,
        described_parameters,
    };
    let found = if is_own_scale { found.in_own_scale() } else { found };
    Ok(match unknowns {
        Some(unknowns) => found.with_unknowns(unknowns),
        None => found,
    })
}

/// Each log predicted by parameters from the others, where there are several. `described`: the base parameters of the description.
fn left_out(model: &Model, fit: &Fit, options: &Options, described: Option<&[f64]>) -> Vec<LogLeftOut> {
    logs_left_out(&options.linear_model(model.regressor()), fit, described)
}

/// An estimate, with its bodies where only those that can exist were asked for.
struct FoundBodies {
    estimate: Estimate,
    bodies: Option<Bodies>,
    evidence: Option<BodiesEvidence>,
    /// Remarks on bodies whose mass differs much from that of the description.
    outgrown: Vec<String>,
}

/// The estimate whose bodies can exist, where only such were asked for. Where the logs do not determine them, the description does.
fn found_bodies(model: &Model, fit: Fit, kept: Kept, options: &Options) -> Result<FoundBodies, Error> {
    if kept != Kept::Consistent {
        return Ok(FoundBodies { estimate: fit.estimate, bodies: None, evidence: None, outgrown: Vec::new() });
    }
    let (map, known) = (model.standard_map(), model.reference_bodies());
    let found = identify_consistent(model.regressor(), &map, &known, fit, options, &Default::default())?;
    let named: Vec<(&str, Ten)> = bodies(&map, &found.consistent.phi).collect();
    let describe = |(body, known): (&(&str, Ten), &Option<Ten>)| outgrown(body, known.as_ref()?);
    let ratio = |((name, body), known): (&(&str, Ten), &Option<Ten>)| {
        let described = known.as_ref()?[9];
        Some((name.to_string(), body[9] / described, described)).filter(|(_, ratio, _)| ratio.is_finite())
    };
    let linear = options.linear_model(model.regressor());
    let at_rest = model.described_parameters().and_then(|described| {
        let Fit { solution, observation, .. } = &found.least_squares;
        farther_at_rest(
            &linear,
            &solution.x,
            &found.consistent.x,
            &described,
            &observation.range,
            &found.estimate.joints,
        )
    });
    let weighed = linear.parameters.iter().filter_map(|p| offset_beside_weight(&linear, p));
    let weighed = weighed.map(|j| linear.regressor.coordinates()[j].clone()).collect();
    let links = model.body_links().into_iter().zip(named.iter().map(|(_, x)| *x)).collect();
    let refusal = found.refusal();
    Ok(FoundBodies {
        bodies: Some(Bodies { links, armatures: armatures(model, &found.consistent.phi), refusal: refusal.clone() }),
        evidence: Some(BodiesEvidence {
            refusal,
            masses: named.iter().zip(&known).filter_map(ratio).collect(),
            at_rest,
            weighed,
        }),
        outgrown: named.iter().zip(&known).filter_map(describe).collect(),
        estimate: found.estimate,
    })
}

/// Rotor inertias by coordinate, kg m^2 (kg); zero where the model has none.
fn armatures(model: &Model, phi: &[f64]) -> Vec<f64> {
    let robot = &model.robot;
    let of_link = |link: LinkId| {
        let is_rotor = |s: &robot::StandardParameter| s.inertial == Inertial::Ia && s.link == link;
        model.parameters.standard.iter().position(is_rotor).map_or(0.0, |c| phi[c])
    };
    let joint = |k: usize| robot.joint_of(robot::value::CoordinateId(k));
    (0..robot.n_coordinates()).map(|k| joint(k).map_or(0.0, of_link)).collect()
}
