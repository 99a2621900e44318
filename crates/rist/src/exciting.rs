//! From a model to one motion that makes its parameters visible, within proved limits.

use identification::experiments::excitation::artefact::MotionJoint;
use identification::experiments::excitation::barrier::Timing;
use identification::experiments::excitation::columns::visible_columns;
use identification::experiments::excitation::criterion::Aim;
use identification::experiments::excitation::fourier_motion::{FourierJoint, FourierMotion};
use identification::experiments::excitation::limits::{CoordinateLimits, LimitKind, LimitsFile, motion_limits};
use identification::experiments::excitation::problem::{Problem, TorqueWall};
use identification::experiments::excitation::proof::{
    CertificateRow, DescribedFriction, DescribedTorque, EnclosedTorque, Kept,
};
use identification::experiments::excitation::search::{Found, NoMotion, SearchOptions, fitted, search};
use identification::experiments::excitation::visibility::visibility;
use identification::model::friction::terms::FrictionTerm;
use identification::model::linear_model::Model as LinearModel;
use identification::model::parameter::FrictionParameter;
use identification::model::regressor::Regressor;
use robot::RotorInertia;
use robot::value::CoordinateId;

pub use identification::algebra::interruption::Interruption;
pub use identification::experiments::excitation::artefact::ExcitingMotion;

use crate::error::Error;
use crate::model::Model;
use crate::regressor_slope::RegressorSlope;
use crate::torque_enclosure::TorqueEnclosure;

/// Which motion is looked for.
#[derive(Clone, Debug)]
pub struct ExciteRequest {
    /// s; none: by the limits, see [`default_period`].
    pub period: Option<f64>,
    /// s from rest to the series; none: by the limits.
    pub blend: Option<f64>,
    /// Number of harmonics.
    pub harmonics: usize,
    /// Whole periods.
    pub repetitions: usize,
    /// Of the file that is played and of the log, Hz.
    pub rate: f64,
    /// Limits tighter than those of the description.
    pub limits: LimitsFile,
    /// Share of the effort limits that the described torque may use.
    pub effort_share: f64,
    /// Friction columns that the identification will have.
    pub friction: Vec<FrictionTerm>,
    /// The aim of the search.
    pub aim: Aim,
    /// Noise of a torque sample as a share of the effort limit.
    pub noise: f64,
    /// Starting points of the search.
    pub starts: usize,
    /// Of each descent, at each height of the walls.
    pub iterations: usize,
    /// Of the starting points.
    pub seed: u64,
}

impl ExciteRequest {
    fn search(&self) -> SearchOptions {
        let threads = std::thread::available_parallelism().map_or(1, usize::from);
        SearchOptions { starts: self.starts, iterations: self.iterations, seed: self.seed, threads }
    }

    fn motion(&self, timing: Timing, joints: Vec<FourierJoint>) -> FourierMotion {
        let Timing { period, blend, .. } = timing;
        FourierMotion { rate: self.rate, period, blend, repetitions: self.repetitions, joints }
    }
}

impl Default for ExciteRequest {
    fn default() -> ExciteRequest {
        ExciteRequest {
            period: None,
            blend: None,
            harmonics: 5,
            repetitions: 3,
            rate: 200.0,
            limits: LimitsFile::default(),
            effort_share: 0.9,
            friction: FrictionTerm::STANDARD.to_vec(),
            aim: Aim::Determinant,
            noise: 0.01,
            starts: 8,
            iterations: 40,
            seed: 1,
        }
    }
}

/// Starts done, starts, criterion (det^(1/p), or cond_fro), and what it comes nearest to.
pub type ExciteProgress<'a> = dyn Fn(usize, usize, &str) + Sync + 'a;

/// Instants a period, for each harmonic: products of three harmonics are still told apart.
const INSTANTS: usize = 30;

/// Torque noise where no effort limit is known, N m (N).
const UNKNOWN_NOISE: f64 = 0.1;

/// Searches the motion with the greatest determinant of the information (or the least condition number) of the columns
/// of an identification, and proves its limits; a motion whose proof fails says so.
///
/// Fails where a number of the request makes no motion, and where the limits leave none.
pub fn excite(model: &Model, request: &ExciteRequest, progress: &ExciteProgress) -> Result<ExcitingMotion, Error> {
    check_request(request)?;
    let regressor = RegressorSlope::new(model)?;
    let names = regressor.coordinates().to_vec();
    let (limits, mut notes) = limits_and_notes(model, &regressor, request)?;
    let timing = timing(request, &limits)?;
    let noise = torque_noise(model, request.noise, &mut notes);

    // What is known of the torques.
    let friction = described_friction(model);
    let enclosure = TorqueEnclosure::new(model).filter(|_| limits.iter().any(|l| l.effort.is_some()));
    let wall = |parameters| TorqueWall { parameters, friction: friction.clone(), share: request.effort_share };
    let wall = model.described_parameters().filter(|_| enclosure.is_some()).map(wall);
    notes.extend(torque_note(model, &names, &limits));

    // The search.
    let linear = LinearModel::new(&regressor, &request.friction, &[]);
    let columns = visible_columns(&linear, &limits);
    let problem = Problem {
        regressor: &regressor,
        friction: &request.friction,
        limits: &limits,
        noise: &noise,
        aim: request.aim,
        torque: wall.as_ref(),
        columns: &columns,
        timing,
    };
    let report =
        |done: usize, found: Option<&Found>| progress(done, request.starts, &progress_text(found, request.aim, &names));
    let found = search(&problem, &request.search(), &report);
    Interruption::check()?;
    let found = found.map_err(|why| refused(model, &names, why))?;

    // The best motion that can be proved; without one the best, which then says so.
    let torque = enclosure.as_ref().map(|torque| described_torque(torque, &friction, request.effort_share));
    let motions = found.into_iter().map(|found| request.motion(timing, found.joints));
    let fits = motions.map(|motion| fitted(motion, &limits, &names, torque.as_ref()));
    let (motion, certificate) = proved_or_first(fits).ok_or_else(|| refused(model, &names, NoMotion::NothingToTell))?;
    let seen = visibility(&linear, &motion, &limits, &noise, &described_values(model, &linear), &certificate);
    Ok(ExcitingMotion {
        model: model.reference.clone(),
        rate_hz: request.rate,
        period_s: timing.period,
        blend_s: timing.blend,
        repetitions: request.repetitions,
        joints: motion_joints(&motion, &names, &limits),
        effort_share: request.effort_share,
        aim: request.aim,
        determinant: seen.determinant,
        condition_number: seen.condition_number,
        torque_noise: noise,
        proven: is_proven(&certificate),
        notes,
        certificate,
        parameters: seen.parameters,
    })
}

/// What a motion may use of the effort limits.
fn described_torque<'a>(
    torque: &'a dyn EnclosedTorque,
    friction: &[DescribedFriction],
    share: f64,
) -> DescribedTorque<'a> {
    DescribedTorque { torque, friction: friction.to_vec(), share }
}

/// The limits of the request within those of the description, and what is to be said of them.
fn limits_and_notes(
    model: &Model,
    regressor: &RegressorSlope,
    request: &ExciteRequest,
) -> Result<(Vec<CoordinateLimits>, Vec<String>), Error> {
    let described: Vec<robot::Limits> = model.robot.coordinates.iter().map(|c| c.limits).collect();
    let is_prismatic = |k: usize| regressor.is_prismatic(k);
    motion_limits(regressor.coordinates(), is_prismatic, &described, &request.limits)
        .map_err(|what| Error::new(format_args!("{}: {what}", model.path.display())))
}

fn is_proven(rows: &[CertificateRow]) -> bool {
    rows.iter().all(|r| r.kept == Kept::Proven)
}

/// The first motion whose limits are all proven; the first of all where none is.
fn proved_or_first(
    mut motions: impl Iterator<Item = (FourierMotion, Vec<CertificateRow>)>,
) -> Option<(FourierMotion, Vec<CertificateRow>)> {
    let first = motions.next()?;
    if is_proven(&first.1) {
        return Some(first);
    }
    Some(motions.find(|(_, rows)| is_proven(rows)).unwrap_or(first))
}

fn motion_joints(motion: &FourierMotion, names: &[String], limits: &[CoordinateLimits]) -> Vec<MotionJoint> {
    let joint = |((series, name), limits): ((&FourierJoint, &String), &CoordinateLimits)| MotionJoint {
        coordinate: name.clone(),
        centre: series.centre,
        cosine: series.cosine.clone(),
        sine: series.sine.clone(),
        limits: limits.clone(),
    };
    motion.joints.iter().zip(names).zip(limits).map(joint).collect()
}

fn check_request(request: &ExciteRequest) -> Result<(), Error> {
    let positive = [
        (Some(request.rate), "--rate"),
        (request.period, "--period"),
        (request.blend, "--blend"),
        (Some(request.noise), "--noise"),
    ];
    for (x, what) in positive.iter().filter_map(|(x, what)| x.map(|x| (x, what))) {
        if !(x.is_finite() && x > 0.0) {
            return Err(Error::new(format_args!("{what} must be a positive number, not {x}")));
        }
    }
    if !(request.effort_share > 0.0 && request.effort_share <= 1.0) {
        let share = request.effort_share;
        return Err(Error::new(format_args!("--effort-share is above 0 and at most 1, not {share}")));
    }
    if request.harmonics == 0 || request.harmonics > 40 {
        return Err(Error::new(format_args!("--harmonics must be between 1 and 40, not {}", request.harmonics)));
    }
    if request.repetitions == 0 || request.starts == 0 {
        return Err(Error::new("--repetitions and --starts must be at least 1"));
    }
    if request.friction.contains(&FrictionTerm::Load) {
        return Err(Error::new("--friction load needs a measured torque; a motion that is still to be run has none"));
    }
    Ok(())
}

/// The period by the limits, s: the fundamental fills the room at the greatest velocity, or the highest harmonic takes
/// the greatest velocity and acceleration together, whichever is longer; the middle one of the joints, 5 to 20 s.
pub fn default_period(limits: &[CoordinateLimits], harmonics: usize) -> f64 {
    let moving = || limits.iter().filter(|l| l.locked.is_none());
    let middle = |of: &dyn Fn(&CoordinateLimits) -> f64| {
        let mut all: Vec<f64> = moving().map(of).collect();
        all.sort_by(f64::total_cmp);
        all.get(all.len() / 2).copied().unwrap_or(0.0)
    };
    let turn = std::f64::consts::TAU;
    let room = middle(&|l| turn * 0.5 * (l.position.1 - l.position.0) / l.velocity);
    let speed = middle(&|l| turn * harmonics as f64 * l.velocity / l.acceleration);
    room.max(speed).clamp(5.0, 20.0)
}

/// The blend by the limits, s: from rest to the greatest velocity at four tenths of the greatest acceleration.
fn default_blend(limits: &[CoordinateLimits]) -> f64 {
    let moving = limits.iter().filter(|l| l.locked.is_none());
    moving.map(|l| 2.5 * l.velocity / l.acceleration).fold(0.5, f64::max)
}

/// Times that are whole numbers of samples.
fn timing(request: &ExciteRequest, limits: &[CoordinateLimits]) -> Result<Timing, Error> {
    let tenths = |x: f64| (10.0 * x).ceil() / 10.0;
    let whole = |x: f64| (x * request.rate).round().max(1.0) / request.rate;
    let period = whole(request.period.unwrap_or_else(|| tenths(default_period(limits, request.harmonics))));
    let blend = whole(request.blend.unwrap_or_else(|| tenths(default_blend(limits))));
    let highest = request.harmonics as f64 / period;
    if highest > 0.1 * request.rate {
        return Err(Error::new(format_args!(
            "the highest harmonic, {highest:.3} Hz, needs ten samples a period: raise --rate ({} Hz) or --period ({period} s)",
            request.rate
        )));
    }
    Ok(Timing { period, blend, harmonics: request.harmonics, samples: (INSTANTS * request.harmonics).max(100) })
}

/// N m (N) a sample, one a coordinate.
fn torque_noise(model: &Model, share: f64, notes: &mut Vec<String>) -> Vec<f64> {
    let coordinates = &model.robot.coordinates;
    let effort = |c: &robot::Coordinate| c.limits.effort.filter(|x| x.is_finite() && *x > 0.0);
    let unknown: Vec<&str> = coordinates.iter().filter(|c| effort(c).is_none()).map(|c| c.name.as_str()).collect();
    if !unknown.is_empty() {
        let names = unknown.join(", ");
        notes.push(format!("{names}: no effort limit given, torque noise of {UNKNOWN_NOISE} N m (N) a sample assumed"));
    }
    coordinates.iter().map(|c| effort(c).map_or(UNKNOWN_NOISE, |e| share * e)).collect()
}

/// Friction of the description, one a coordinate.
pub(crate) fn described_friction(model: &Model) -> Vec<DescribedFriction> {
    let of = |k: usize| {
        let joint = model.robot.joint_of(CoordinateId(k)).map(|j| &model.robot.link(j).joint);
        let friction = joint.map(|j| j.friction).unwrap_or_default();
        DescribedFriction {
            viscous: friction.viscous.unwrap_or(0.0),
            coulomb: friction.coulomb.unwrap_or(0.0),
            offset: friction.offset.unwrap_or(0.0),
        }
    };
    (0..model.robot.n_coordinates()).map(of).collect()
}

/// Why torques are not looked at, if so.
pub(crate) fn torque_note(model: &Model, names: &[String], limits: &[CoordinateLimits]) -> Option<String> {
    if model.described_parameters().is_none() {
        return Some("torques are not looked at: the description has no inertial parameters".into());
    }
    let unknown = names.iter().zip(limits).filter(|(_, l)| l.effort.is_none());
    let unknown: Vec<&str> = unknown.map(|(name, _)| name.as_str()).collect();
    let names = unknown.join(", ");
    (!unknown.is_empty()).then(|| format!("torques of {names} are not looked at: no effort limit given"))
}

/// Values of the description, one a parameter of the model.
fn described_values(model: &Model, linear: &LinearModel) -> Vec<Option<f64>> {
    let base = model.described_parameters();
    let count = model.regressor().parameters().len();
    let mut values: Vec<Option<f64>> = (0..count).map(|c| base.as_ref().map(|b| b[c])).collect();
    for k in 0..linear.n() {
        let joint = model.robot.joint_of(CoordinateId(k)).map(|j| &model.robot.link(j).joint);
        let friction = joint.map(|j| j.friction).unwrap_or_default();
        let rotor = joint.and_then(|j| if let RotorInertia::Known(x) = j.rotor_inertia { Some(x) } else { None });
        values.extend(linear.friction.iter().flat_map(|t| t.parameters()).map(|p| match p {
            FrictionParameter::Viscous | FrictionParameter::ViscousForward | FrictionParameter::ViscousBackward => {
                friction.viscous
            }
            FrictionParameter::Coulomb => friction.coulomb,
            FrictionParameter::Offset => friction.offset,
            FrictionParameter::Rotor => rotor,
            _ => None,
        }));
    }
    values
}

fn progress_text(found: Option<&Found>, aim: Aim, names: &[String]) -> String {
    let Some(found) = found else { return "no motion within the limits".into() };
    let value = match aim {
        Aim::Determinant => format!("det^(1/p) {:.4e}", (-found.criterion).exp()),
        Aim::Condition => format!("cond_fro {:.2}", found.criterion.exp()),
    };
    let (room, k, limit): (f64, usize, LimitKind) = found.room;
    let torque = found
        .torque
        .map(|(share, k)| format!(", torque at most {:.0} % of what it may be ({})", 100.0 * share, names[k]));
    format!("{value}, least room {:.2} % ({limit} of {}){}", 100.0 * room, names[k], torque.unwrap_or_default())
}

fn refused(model: &Model, names: &[String], why: NoMotion) -> Error {
    let path = model.path.display();
    match why {
        NoMotion::AllLocked => {
            Error::new(format_args!("{path}: every coordinate is locked: unlock one in the limits file"))
        }
        NoMotion::NothingToTell => Error::new(format_args!(
            "{path}: no motion of the coordinates that are not locked tells any parameter: unlock more of them"
        )),
        NoMotion::TooWeak { coordinate, share } => Error::new(format_args!(
            "{path}: no motion keeps the effort limit of {}: hardly moving it takes {:.0} % of what it may; the limits of \
             position leave no pose that is light enough, or the effort limit, the inertial parameters or --effort-share \
             are too small or too great",
            names[coordinate],
            100.0 * share
        )),
    }
}
