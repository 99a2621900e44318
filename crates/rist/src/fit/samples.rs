//! Identifies parameters from logs, in steps: gains, delay, friction, fit, physically possible bodies, load, remarks.
//!
//! tau = W X: regression equations, with torques tau, regression matrix W and parameters X. Bodies are the ten inertial
//! parameters of each link; they are physically possible if a real body can have them. Held-out segments are parts of the logs
//! that are left out of the fit and predicted. Unknowns are quantities besides the parameters: mount of the base, encoder
//! zeros, torque scales, springs. A fault is a possible mistake of a log, tested as one additional unknown.

use identification::estimate::absent_friction::absent_friction;
use identification::estimate::claims::hypotheses::HypothesisTest;
use identification::estimate::claims::inflate_by_unknowns;
use identification::estimate::consistent::{bodies, identify_consistent};
use identification::estimate::essential::keep_essential;
use identification::estimate::identify::Fit;
use identification::estimate::impossible::impossible;
use identification::estimate::log_check::LogCheck;
use identification::estimate::logs_left_out::{LogLeftOut, logs_left_out, sentence as of_left_out};
use identification::estimate::options::Options;
use identification::estimate::remarks::exceeding_description;
use identification::estimate::standing_torque::{farther_at_rest, offset_beside_weight};
use identification::estimate::verdict::{BodiesEvidence, Evidence, Prediction, Trust, Verdict};
use linear_model::pseudo_inertia::Ten;
use linear_model::standard_map::StandardMap;
use logs::LogSource;
use robot::{Inertial, LinkId};

use crate::describe::model::Model;
use crate::error::Error;
use crate::fit::candidates::contact::contact;
use crate::fit::candidates::dead_current::dead_currents;
use crate::fit::candidates::delay::delay;
use crate::fit::candidates::friction::{asked_friction, joint_friction};
use crate::fit::candidates::gains::gains;
use crate::fit::candidates::mount::mount;
use crate::fit::candidates::possible_bodies::{nominal_error, possible_bodies};
use crate::fit::candidates::rates::rates;
use crate::fit::candidates::rotors::{rotors, significant_rotors};
use crate::fit::candidates::unknowns::Unknowns;
use crate::fit::drive_gains::{OWN_SCALE, gain_remark, is_own_scale};
use crate::fit::load::{Load, Scales, load};
pub use crate::fit::search::Decisions;
use crate::fit::search::{FitQuestion, Fitted, KeptParameters, SearchResult, TriedVariant, VariantProposer, search};
use crate::fit::unsure_torques::{Noise, UnsureTorques};
use crate::request::Request;
pub use crate::request::{IdentifyRequest, SamplesRequest};
pub use claims::Claim;
use identification::estimate::artefact::Estimate;

/// The outcome of an identification.
pub struct Identification {
    /// The model of the fit, if it differs from the given model; `None` if it is the given model. The model of the fit may have
    /// rotor inertias, for example, which a URDF cannot contain.
    pub model: Option<Model>,
    /// Parameter values, intervals, residuals and remarks.
    pub estimate: Estimate,
    /// The decisions made before the fit.
    pub decided: Decisions,
    /// The load in the loaded logs; `None` without such logs.
    pub load: Option<Load>,
    /// The identified bodies; `None` if the request did not ask for physically possible bodies.
    pub bodies: Option<Bodies>,
    /// The log check: whether the logs belong to the description.
    pub log_check: LogCheck,
    /// Relative error |tau - W X| / |tau| of the description with fitted friction; `None` if the description has no inertial
    /// parameters.
    pub described: Option<f64>,
    /// Relative error |tau - W X| / |tau| of least squares on held-out segments of the logs, each predicted from the other
    /// segments.
    pub held_out: Option<f64>,
    /// If there are several logs: the error of each log, predicted by parameters from the other logs.
    pub logs_left_out: Vec<LogLeftOut>,
    /// Evidence for and against the use of the identified bodies.
    pub bodies_evidence: Option<BodiesEvidence>,
    /// Noise, gains and unknowns, from which the uncertainty of predicted torques is computed.
    pub(crate) unsure: UnsureTorques,
    /// Possible faults of the logs, each tested as one additional unknown.
    pub faults: Vec<HypothesisTest>,
    /// Whether the residuals have outliers at some times.
    pub has_events: bool,
    /// Base parameters from the inertial parameters of the description; `None` if the description has no inertial parameters.
    pub described_parameters: Option<Vec<f64>>,
}

impl Identification {
    /// The model of the fit. `given`: the model of the request.
    pub fn used<'a>(&'a self, given: &'a Model) -> &'a Model {
        self.model.as_ref().unwrap_or(given)
    }

    /// Adds the identified unknowns: the uncertainty of the unknowns to the standard deviations, and the values of the unknowns
    /// to the remarks and decisions.
    fn with_unknowns(mut self, mut unknowns: Unknowns) -> Identification {
        inflate_by_unknowns(&mut self.estimate, &unknowns.steps);
        self.estimate.remarks.splice(..0, unknowns.remarks);
        self.decided.unknowns.append(&mut unknowns.steps);
        Identification { model: self.model.or(unknowns.model), ..self }
    }

    /// Judges whether to trust the estimate. If the verdict is no, the estimate stores the reasons. `prediction`: errors on
    /// logs that were not fitted, if any.
    pub(crate) fn judge(&mut self, prediction: Prediction) -> Verdict {
        self.estimate.refusal = Vec::new();
        let parts_are_new = self.log_check.visited.has_new_parts();
        let verdict = Verdict::of(&Evidence {
            estimate: &self.estimate,
            log_check: Some(&self.log_check),
            described: self.described,
            nominal_parameters: self.described_parameters.as_deref(),
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

/// Identified physically possible bodies, and rotor inertias.
pub struct Bodies {
    /// For each link that has inertials: XX XY XZ YY YZ ZZ (kg m^2), MX MY MZ (kg m), M (kg) about the origin of the link
    /// frame.
    pub links: Vec<(LinkId, Ten)>,
    /// Rotor inertia of each coordinate, kg m^2 (kg); zero if the model has no rotor inertia.
    pub armatures: Vec<f64>,
    /// The reason why the bodies must not be used, if any. With a reason, no file for a simulator is written.
    pub refusal: Option<String>,
}

/// Identifies the base parameters and the friction of a robot from its logs.
///
/// Fails if the logs do not fit the robot; fails with a verdict if a gain or the delay is not identifiable. A base parameter
/// that is not identifiable is no failure: the status of the parameter states this.
pub fn identify(model: &Model, logs: &[LogSource], request: &IdentifyRequest) -> Result<Identification, Error> {
    identify_loaded(model, logs, &[], request)
}

/// Identifies the parameters like [`identify`], and the load in the logs `loaded` of the same robot.
///
/// Fails like [`identify`], and if the link of the load does not exist.
pub fn identify_loaded(
    model: &Model,
    logs: &[LogSource],
    loaded: &[LogSource],
    request: &IdentifyRequest,
) -> Result<Identification, Error> {
    request.check()?;
    check_arm(&request.samples)?;
    let kept = match (request.consistent, request.free_bodies) {
        (true, true) => return Err(Error::new("[free_bodies=true] and [consistent=true] exclude one another")),
        (true, false) => KeptParameters::Consistent,
        (false, true) => KeptParameters::Free,
        (false, false) => KeptParameters::All,
    };
    identify_kept(model, logs, loaded, &request.samples, kept)
}

/// Identifies only the essential parameters (the smallest set with nearly the same residual); all other parameters are zero. No
/// bodies are computed, because bodies need all parameters. Loads are identified as in [`identify_loaded`].
///
/// Fails like [`identify`].
pub fn identify_essential(
    model: &Model,
    logs: &[LogSource],
    loaded: &[LogSource],
    request: &SamplesRequest,
) -> Result<Identification, Error> {
    request.check()?;
    check_arm(request)?;
    identify_kept(model, logs, loaded, request, KeptParameters::Essential)
}

/// Decisions that are tried in this order. The request can fix each of them.
const CANDIDATES: [VariantProposer; 11] = [
    gains,
    rates,
    contact,
    rotors,
    delay,
    asked_friction,
    significant_rotors,
    mount,
    dead_currents,
    joint_friction,
    possible_bodies,
];

fn identify_kept(
    model: &Model,
    logs: &[LogSource],
    loaded: &[LogSource],
    request: &SamplesRequest,
    kept: KeptParameters,
) -> Result<Identification, Error> {
    let unknowns = (!request.unknowns.is_empty()).then(|| Unknowns::find(model, logs, request)).transpose()?;
    let model = unknowns.as_ref().and_then(|unknowns| unknowns.model.as_ref()).unwrap_or(model);
    let request = unknowns.as_ref().map_or(request, |unknowns| &unknowns.request);
    let options = Options { model: model.robot.name.clone(), ..request.options() };
    let is_own_scale = is_own_scale(model, logs, &request.gain, &options)?;
    let finish = |tried: TriedVariant<'_>| tried.finish();
    let question = FitQuestion { logs, request, kept };
    let SearchResult { model: changed, options, found: decided, end } =
        search(model, question, options, &CANDIDATES, &finish)?;
    let (mut log_check, Fitted { mut fit, faults }, events) = end;
    let model = changed.as_ref().unwrap_or(model);
    let (gains, map, link) = (decided.gains.as_ref(), model.standard_map(), request.loaded_link.as_deref());
    // Load and noise are computed before the physically possible bodies, because these bodies may change the fit.
    let scales = Scales { gains, faults: &faults, log_check: &log_check };
    let of_gains = gains.map(|found| gain_remark(model, logs, &request.gain, found));
    let load = (!loaded.is_empty()).then(|| load(model, &map, link, &fit, loaded, &options, &scales)).transpose()?;
    let noise = Noise::of(&fit);
    let kept = if decided.possible_bodies { KeptParameters::Consistent } else { kept };
    let mut found = found_bodies(model, &map, &mut fit, kept, &options)?;
    if decided.possible_bodies {
        // The request did not ask for bodies, so only the restricted estimate is kept.
        (found.bodies, found.evidence, found.exceeding_description) = (None, None, Vec::new());
    }
    let described_parameters = model.nominal_parameters();
    let described = described_parameters.as_ref().map(|x| nominal_error(model, &fit, &options, x));
    let logs_left_out = logs_left_out(&options.linear_model(model.regressor()), &fit, described_parameters.as_deref());
    if is_own_scale {
        found.refuse(format!("{OWN_SCALE}: no body in kg follows without [gain]"));
    }

    // Adds remarks to the estimate, among them a remark on the gains on which the estimate depends.
    let fingerprint = Some(model.reference.fingerprint.clone());
    let mut estimate = Estimate { fingerprint, description: model.description.clone(), ..found.estimate };
    estimate.remarks.extend(of_gains);
    let unsure = UnsureTorques::inflation(&mut estimate, noise, gains, &faults, model, &options);
    estimate.doubts.extend([impossible(&map, &estimate), events.clone()].concat());
    estimate.remarks.splice(..0, decided.sentences.clone());
    estimate.remarks.extend(of_left_out(&logs_left_out, &estimate.logs));
    estimate.remarks.extend(found.exceeding_description);
    inflate_by_unknowns(&mut estimate, &decided.unknowns);
    if is_own_scale {
        log_check.efforts_are_position_errors(OWN_SCALE);
        estimate.remarks.insert(0, OWN_SCALE.into());
    }
    let found = Identification {
        has_events: !events.is_empty() || log_check.has_changed_load(),
        model: changed,
        estimate: with_absent_friction(estimate, &fit),
        decided,
        load,
        bodies: found.bodies,
        log_check,
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

/// Fails if the request names an arm, because the logs are open already.
fn check_arm(request: &SamplesRequest) -> Result<(), Error> {
    match &request.arm {
        None => Ok(()),
        Some(arm) => Err(Error::new(format_args!(
            "[arm={arm}] says how logs are read, and they are open: complete the request before (SamplesRequest::with_arm)"
        ))),
    }
}

/// The estimate. If the torques of the logs contain no friction, a remark on this is added.
fn with_absent_friction(mut estimate: Estimate, fit: &Fit) -> Estimate {
    let absent = absent_friction(&estimate, &fit.observation.speed);
    estimate.remarks.extend(absent);
    estimate
}

/// An estimate. It has bodies if the request asks for physically possible bodies.
struct FoundBodies {
    estimate: Estimate,
    bodies: Option<Bodies>,
    evidence: Option<BodiesEvidence>,
    /// Remarks on bodies whose mass differs much from the nominal mass.
    exceeding_description: Vec<String>,
}

impl FoundBodies {
    /// Refuses the bodies if the torques are unscaled, because a description in N m cannot be compared with them.
    fn refuse(&mut self, why: String) {
        self.exceeding_description.clear();
        if let (Some(bodies), Some(evidence)) = (&mut self.bodies, &mut self.evidence) {
            evidence.refusal = Some(why.clone());
            evidence.masses.clear();
            bodies.refusal = Some(why);
        }
    }
}

/// The estimate, with physically possible bodies if they were requested. Parameters that the logs do not identify get values
/// from the description.
fn found_bodies(
    model: &Model,
    map: &StandardMap,
    fit: &mut Fit,
    kept: KeptParameters,
    options: &Options,
) -> Result<FoundBodies, Error> {
    let (known, rotors) = (model.reference_bodies(), rotor_columns(model));
    if kept == KeptParameters::Essential {
        keep_essential(model.regressor(), fit, options);
    }
    if kept != KeptParameters::Consistent {
        return Ok(FoundBodies {
            estimate: fit.estimate.clone(),
            bodies: None,
            evidence: None,
            exceeding_description: Vec::new(),
        });
    }
    let found = identify_consistent(model.regressor(), map, &known, fit, options, &Default::default())?;
    let phi = &found.consistent.phi;
    let armatures = rotors.into_iter().map(|column| column.map_or(0.0, |c| phi[c])).collect();
    // Ratio of the identified mass to the described mass. A large difference is evidence against the bodies.
    let named: Vec<(&str, Ten)> = bodies(map, phi).collect();
    let describe = |(body, known): (&(&str, Ten), &Option<Ten>)| exceeding_description(body, known.as_ref()?);
    let ratio = |((name, body), known): (&(&str, Ten), &Option<Ten>)| {
        let described = known.as_ref()?[9];
        Some((name.to_string(), body[9] / described, described)).filter(|(_, ratio, _)| ratio.is_finite())
    };
    // Bodies are refused if their torques at rest deviate from the fit by more than the torques of the described bodies.
    let linear = options.linear_model(model.regressor());
    let at_rest = model.nominal_parameters().and_then(|described| {
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
    // For a sliding joint that carries the same weight in every pose, friction offset and weight are not separable.
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
        exceeding_description: named.iter().zip(&known).filter_map(describe).collect(),
        estimate: found.estimate,
    })
}

/// For each coordinate, the index of the standard parameter of its rotor inertia; `None` if the model has no such parameter.
fn rotor_columns(model: &Model) -> Vec<Option<usize>> {
    let robot = &model.robot;
    let of_link = |link: LinkId| {
        let is_rotor = |s: &robot::StandardParameter| s.inertial == Inertial::Ia && s.link == link;
        model.parameters.standard.iter().position(is_rotor)
    };
    (0..robot.n_coordinates()).map(|k| robot.joint_of(robot::value::CoordinateId(k)).and_then(of_link)).collect()
}
