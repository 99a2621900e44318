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
use identification::estimate::standing_out::StandingOut;
use identification::estimate::standing_torque::{farther_at_rest, offset_beside_weight};
use identification::estimate::verdict::{BodiesEvidence, Evidence, Prediction, Trust, Verdict};
use linear_model::pseudo_inertia::Ten;
use linear_model::standard_map::StandardMap;
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
    /// Whether residuals stand out at some times.
    pub has_events: bool,
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
            prediction: Prediction {
                held_out: self.held_out,
                parts_are_new,
                has_events: self.has_events,
                ..prediction
            },
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

/// Residuals that stand out, in words.
fn of_events(model: &Model, logs: &[String], events: &[StandingOut]) -> Vec<String> {
    let of_log = |event: &StandingOut| logs.get(event.log).filter(|_| logs.len() > 1).map(String::as_str);
    let name = |event: &StandingOut| &model.regressor().coordinates()[event.joint];
    events.iter().map(|event| event.statement(name(event), of_log(event))).collect()
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
    let Searched { model: changed, options, found: decided, end } = searched;
    let (mut passport, Fitted { mut fit, faults }, events) = end;
    let model = changed.as_ref().unwrap_or(model);
    let (gains, map) = (decided.gains.as_ref(), model.standard_map());
    let link = request.loaded_link.as_deref();
    let scales = Scales { gains, faults: &faults, passport: &passport };
    let of_gains = gains.map(|found| gain_remark(model, logs, &request.gain, found));
    let load = (!loaded.is_empty()).then(|| load(model, &map, link, &fit, loaded, &options, &scales)).transpose()?;
    let noise = Noise::of(&fit);
    let kept = if decided.possible_bodies { Kept::Consistent } else { kept };
    let mut found = found_bodies(model, &map, &mut fit, kept, &options)?;
    if decided.possible_bodies {
        // Nobody asked for a file of bodies.
        (found.bodies, found.evidence, found.outgrown) = (None, None, Vec::new());
    }
    let described_parameters = model.described_parameters();
    let described = described_parameters.as_ref().map(|x| described_error(model, &fit, &options, x));
    let logs_left_out = logs_left_out(&options.linear_model(model.regressor()), &fit, described_parameters.as_deref());
    if is_own_scale {
        found.refuse(format!("{OWN_SCALE}: no body in kg follows without [gain]"));
    }

    // The remarks, and the gains that the estimate stands on.
    let fingerprint = Some(model.reference.fingerprint.clone());
    let mut estimate = Estimate { fingerprint, description: model.description.clone(), ..found.estimate };
    estimate.remarks.extend(of_gains);
    let unsure = UnsureTorques::widening(&mut estimate, noise, gains, &faults, model, &options);
    estimate.doubts.extend([impossible(&map, &estimate), of_events(model, &estimate.logs, &events)].concat());
    estimate.remarks.splice(..0, decided.sentences.clone());
    estimate.remarks.extend(of_left_out(&logs_left_out, &estimate.logs));
    estimate.remarks.extend(found.outgrown);
    widen_by_unknowns(&mut estimate, &decided.unknowns);
    if is_own_scale {
        passport.efforts_are_position_errors(OWN_SCALE);
        estimate.remarks.insert(0, OWN_SCALE.into());
    }
    let found = Identification {
        has_events: !events.is_empty() || passport.has_changed_load(),
        model: changed,
        estimate,
        decided,
        load,
        bodies: found.bodies,
        passport,
        described: described.filter(|_| !is_own_scale),
        held_out: fit.estimate.cross_validation,
        logs_left_out,
        bodies_evidence: found.evidence,
        unsure,
        faults,
        described_parameters: described_parameters.filter(|_| !is_own_scale),
    };
    Ok(match unknowns {
        Some(unknowns) => found.with_unknowns(unknowns),
        None => found,
    })
}

/// An estimate, with its bodies where only those that can exist were asked for.
struct FoundBodies {
    estimate: Estimate,
    bodies: Option<Bodies>,
    evidence: Option<BodiesEvidence>,
    /// Remarks on bodies whose mass differs much from that of the description.
    outgrown: Vec<String>,
}

impl FoundBodies {
    /// Forbids the bodies, for torques that are up to the gains of servos: nothing is held against a description in N m.
    fn refuse(&mut self, why: String) {
        self.outgrown.clear();
        if let (Some(bodies), Some(evidence)) = (&mut self.bodies, &mut self.evidence) {
            evidence.refusal = Some(why.clone());
            evidence.masses.clear();
            bodies.refusal = Some(why);
        }
    }
}

/// The estimate whose bodies can exist, where only such were asked for. Where the logs do not determine them, the description does.
fn found_bodies(
    model: &Model,
    map: &StandardMap,
    fit: &mut Fit,
    kept: Kept,
    options: &Options,
) -> Result<FoundBodies, Error> {
    let (known, rotors) = (model.reference_bodies(), rotor_columns(model));
    if kept == Kept::Essential {
        keep_essential(model.regressor(), fit, options);
    }
    if kept != Kept::Consistent {
        return Ok(FoundBodies { estimate: fit.estimate.clone(), bodies: None, evidence: None, outgrown: Vec::new() });
    }
    let found = identify_consistent(model.regressor(), map, &known, fit, options, &Default::default())?;
    let phi = &found.consistent.phi;
    let armatures = rotors.into_iter().map(|column| column.map_or(0.0, |c| phi[c])).collect();
    let named: Vec<(&str, Ten)> = bodies(map, phi).collect();
    let describe = |(body, known): (&(&str, Ten), &Option<Ten>)| outgrown(body, known.as_ref()?);
    let ratio = |((name, body), known): (&(&str, Ten), &Option<Ten>)| {
        let described = known.as_ref()?[9];
        Some((name.to_string(), body[9] / described, described)).filter(|(_, ratio, _)| ratio.is_finite())
    };
    let linear = options.linear_model(model.regressor());
    let at_rest = model.described_parameters().and_then(|described| {
        let Fit { solution, observation, .. } = &*fit;
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
        bodies: Some(Bodies { links, armatures, refusal: refusal.clone() }),
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

/// By coordinate, which standard parameter its rotor inertia is, kg m^2 (kg); `None` where the model has none.
fn rotor_columns(model: &Model) -> Vec<Option<usize>> {
    let robot = &model.robot;
    let of_link = |link: LinkId| {
        let is_rotor = |s: &robot::StandardParameter| s.inertial == Inertial::Ia && s.link == link;
        model.parameters.standard.iter().position(is_rotor)
    };
    (0..robot.n_coordinates()).map(|k| robot.joint_of(robot::value::CoordinateId(k)).and_then(of_link)).collect()
}
