//! The functions `rist.plan`, `rist.simulate`, `rist.excite` and `rist.check`: motions, their simulated logs, and their proofs.

use std::path::{Path, PathBuf};

use numpy::PyArrayDyn;
use pyo3::exceptions::PyUserWarning;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rist::motion::simulation::{Motions, SimulateRequest};
use rist::request::{CheckRequest, ExciteRequest, PlanRequest};
use rist::{Effort, Interpolation, PlayedFile, Record};

use crate::arrays::array;
use crate::artefact::{make_directory, read_text, save};
use crate::call::Call;
use crate::error::{OrError, error, warn};
use crate::estimate::Estimate;
use crate::model::Model;
use crate::motions::{ExcitingMotion, ExperimentPlan};
use crate::work::{alone, work};

/// Chooses the experiments with which a robot is identified best by spectrum analysis. If the description lacks data, one
/// warning lists the assumptions.
///
/// model: a Model, or the path of a description.
///
/// Options:
/// - experiments: Number of experiments [default: 8]
/// - criterion: What the choice of the experiments optimises [default: 'determinant']
/// - profile: Profile of the acceleration within a swing, which is a motion between two positions and back
///   [default: 'bang-bang']
/// - steps: Number of grid positions of each coordinate [default: 5]
/// - configurations: Maximum number of configurations for each kind of motion [default: 60]
/// - limits: YAML with tighter limits of joints and bodies, as for limits= of `rist excite`
/// - effort_share: Share of the limits of effort that the torque computed from the description may use [default:
///   0.9]
/// - duration: Recorded time of one experiment, s [default: 4.0]
/// - rate: Sample rate of the controller, Hz [default: 1000.0]
/// - starts: Number of starts of the search [default: 12]
/// - seed: Seed of the random starts; the same seed gives the same plan [default: 1]
/// - nodes: Maximum number of nodes of a branch-and-bound search; 0: no such search. The search improves the
///   plan, and proves how far the plan can be from the best plan. It ends when the D-efficiency is within 0.001
///   of the best. The proof is written into the plan [default: 0]
/// - progress: Called with (done, all, text) during the work
#[pyfunction]
#[pyo3(signature = (model, **options), text_signature = "(model, *, experiments=8, criterion='determinant', profile='bang-bang', steps=5, configurations=60, limits=None, effort_share=0.9, duration=4.0, rate=1000.0, starts=12, seed=1, nodes=0, progress=None)")]
pub fn plan(py: Python<'_>, model: &Bound<'_, PyAny>, options: Option<&Bound<'_, PyDict>>) -> PyResult<ExperimentPlan> {
    let model = Model::of(model)?;
    let inner = &model.get().inner;
    let call = Call::new("plan", &["progress"], options)?;
    let request: PlanRequest = call.request()?;
    let planned = work(py, call.own("progress"), |reporter| {
        rist::plan(inner, &request, &|done, all, best| reporter.tell(done, all, &format!("best {best:.3}")))
    })?;
    if !planned.notes.is_empty() {
        warn(py, &planned.notes.join("; "), py.get_type::<PyUserWarning>().as_any())?;
    }
    Ok(ExperimentPlan { inner: planned.plan, model: Some(model.unbind()) })
}

/// Simulates the experiments of a plan, or an ExcitingMotion, in closed loop, with friction, noise and drive gains. `.notes` of
/// the returned estimate lists the assumptions about what the description does not say.
///
/// model: a Model, or the path of a description. plan: a plan or a motion, or the path of one.
///
/// With out="DIRECTORY", writes the same files as `rist simulate`: one log per experiment (e01.csv, ..) or motion.csv, logs of
/// other motions for validation (v01.csv, ..), truth.yaml, and with a load also e01_loaded.csv, .. and truth_loaded.yaml.
/// Returns an Estimate with the true parameters behind the logs, and a dict of the logs by name. A log is a dict of arrays that
/// `identify` takes: t (N,) in s, q (N, n) in rad (m), and i (N, n) in A, or tau (N, n) in N m (N) if no drive gain is known.
///
/// Options:
/// - validation: Number of validation motions [default: 10]
/// - gain: Drive gain (torque per current), N m/A [default: as in the file; if only some gains are known, 1 for
///   the others]
/// - load: A known load, in a file as for load= of `rist identify`. Every experiment is repeated with this load:
///   e01_loaded.csv, ..
/// - feedforward: Estimate from which the controller computes feedforward torques
/// - seed: Seed of the noise; the same seed gives the same logs [default: 1]
/// - noise_free: Simulate sensors without noise and without rounding [default: False]
/// - out: Directory to which the logs are written
/// - progress: Called with (done, all, text) during the work
#[pyfunction]
#[pyo3(signature = (model, plan, **options), text_signature = "(model, plan, *, validation=10, gain=None, load=None, feedforward=None, seed=1, noise_free=False, out=None, progress=None)")]
pub fn simulate<'py>(
    py: Python<'py>,
    model: &Bound<'py, PyAny>,
    plan: &Bound<'py, PyAny>,
    options: Option<&Bound<'py, PyDict>>,
) -> PyResult<(Estimate, Bound<'py, PyDict>)> {
    let call = Call::new("simulate", &["out", "feedforward", "progress"], options)?;
    let model = Model::of(model)?;
    let inner = &model.get().inner;
    let motions = Played::of(plan, inner)?;
    let mut request: SimulateRequest = call.request()?;
    request.feedforward = estimate_of(&call, "feedforward")?;
    let out = call.own("out").map(|out| out.extract::<PathBuf>()).transpose()?;
    if let Some(out) = &out {
        make_directory(out)?;
    }
    let effort = request.effort(inner);
    let planned = motions.count();
    let all = planned * (1 + usize::from(request.load.is_some())) + request.validation;
    // Each record is written to disk as soon as it is simulated. It is also returned to the caller.
    let (simulated, records) = work(py, call.own("progress"), |reporter| {
        let mut records: Vec<(String, Record)> = Vec::new();
        let take = &mut |name: &str, record: &Record| {
            if let Some(out) = &out {
                let text = record.to_csv(inner.regressor().coordinates(), effort);
                rist::output::write_file(&out.join(format!("{name}.csv")), &text, &[&inner.path])?;
            }
            records.push((name.into(), record.clone()));
            reporter.tell(records.len(), all, name);
            Ok(())
        };
        let simulated = rist::simulate(inner, motions.motions(), &request, take)?;
        Ok((simulated, records))
    })?;
    if let Some(out) = &out {
        save(&out.join("truth.yaml"), &simulated.truth.to_yaml().or_error()?, &[&inner.path])?;
        if let Some(loaded) = &simulated.loaded_truth {
            save(&out.join("truth_loaded.yaml"), &loaded.to_yaml().or_error()?, &[&inner.path])?;
        }
    }
    let logs = logs_of(py, &records, effort)?;
    let truth = Estimate::plain(simulated.truth, Some(model.unbind()));
    Ok((Estimate { notes: simulated.notes, ..truth }, logs))
}

/// Motions to simulate: the experiments of a plan, or one exciting motion.
enum Played {
    Plan(rist::motion::planning::ExperimentPlan),
    Motion(rist::motion::exciting::ExcitingMotion),
}

impl Played {
    /// Takes a motion, a plan, or the path of one. Fails if it was made with another model.
    fn of(given: &Bound<'_, PyAny>, model: &rist::Model) -> PyResult<Played> {
        let file = given.extract::<PathBuf>().ok();
        let is_motion = match &file {
            Some(path) => rist::ArtefactKind::of(&read_text(path)?) == Some(rist::ArtefactKind::Motion),
            None => given.is_instance_of::<ExcitingMotion>(),
        };
        if !is_motion {
            return Ok(Played::Plan(ExperimentPlan::of(given, model)?));
        }
        let motion = ExcitingMotion::of(given)?;
        model.check(Path::new("motion"), &motion.model).or_error()?;
        Ok(Played::Motion(motion))
    }

    fn motions(&self) -> Motions<'_> {
        match self {
            Played::Plan(plan) => plan.into(),
            Played::Motion(motion) => motion.into(),
        }
    }

    /// The number of simulated records. Records with a load are not counted.
    fn count(&self) -> usize {
        match self {
            Played::Plan(plan) => plan.experiments.len(),
            Played::Motion(_) => 1,
        }
    }
}

/// The argument `name` as an estimate; `None` if it is absent. Fails if it is no estimate.
fn estimate_of(call: &Call<'_>, name: &str) -> PyResult<Option<rist::Estimate>> {
    let Some(estimate) = call.own(name) else { return Ok(None) };
    match estimate.cast::<Estimate>() {
        Ok(estimate) => Ok(Some(estimate.get().inner.clone())),
        Err(_) => Err(error(format_args!("{}: {name} is an Estimate", call.function))),
    }
}

/// Records as a dict: name -> dict of arrays. `effort`: whether the records contain torques or currents.
fn logs_of<'py>(py: Python<'py>, records: &[(String, Record)], effort: Effort) -> PyResult<Bound<'py, PyDict>> {
    let logs = PyDict::new(py);
    for (name, record) in records {
        logs.set_item(name, log(py, record, effort)?)?;
    }
    Ok(logs)
}

/// A record as a dict of the arrays t, q, and tau or i. `effort` selects tau or i.
fn log<'py>(py: Python<'py>, record: &Record, effort: Effort) -> PyResult<Bound<'py, PyDict>> {
    let log = PyDict::new(py);
    let n = record.q.first().map_or(0, Vec::len);
    let t: Vec<f64> = (0..n).map(|i| i as f64 * record.sample_time).collect();
    log.set_item("t", array(py, &[n], &t)?)?;
    log.set_item("q", samples(py, n, &record.q)?)?;
    let name = if effort == Effort::Torque { "tau" } else { "i" };
    log.set_item(name, samples(py, n, &record.current)?)?;
    Ok(log)
}

/// One series per joint as an array of shape (n, joints).
fn samples<'py>(py: Python<'py>, n: usize, series: &[Vec<f64>]) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
    let numbers: Vec<f64> = (0..n).flat_map(|i| series.iter().map(move |x| x[i])).collect();
    array(py, &[n, series.len()], &numbers)
}

/// Searches for one motion of all joints that excites the parameters, and proves that the motion keeps its limits. Look at
/// `.proven` before you play the motion: it is False if the proof failed.
///
/// model: a Model, or the path of a description.
///
/// Options:
/// - motion: The form of the motion [default: 'fourier']
/// - period: Period of the series, or duration of a spline from rest to rest, s [default: from the limits, 5 to
///   20]
/// - frequency: Base frequency of the series, Hz: the inverse of period=. Give only one of the two options
/// - harmonics: Number of harmonics of the base frequency [default: from the limits and the period, 5 to 8; 5 for
///   more than 8 joints]
/// - spans: Number of polynomial segments (spans) of a spline. With more spans the motion is freer, and the
///   search is longer [default: from the limits, 8 to 30]
/// - repetitions: Number of whole periods between the blends, or of repetitions of a spline [default: 3]
/// - blend: Duration of the blend from rest to the series, and of the blend back to rest, s [default: from the
///   limits]
/// - rate: Sample rate of the file to play and of the log, Hz [default: 200.0]
/// - limits: YAML with tighter limits. `coordinates: {NAME: {position: [LOW, HIGH], velocity, acceleration, jerk,
///   effort, power, locked: POSITION, slowed: FACTOR}}` limits single coordinates; `all:` limits every coordinate
///   in the same way. `space:` limits the bodies, in the base frame, m: `{floor: Z or none, walls: [{point,
///   normal, links}], boxes: [{low, high, links}], distance: 0.01, own_links: true, accept: [[LINK, LINK,
///   REASON]]}`. `margins:` has the errors for which the proof must hold too: `{encoder_zero, tracking,
///   calibration, mesh, payload: {link, mass, centre_of_mass}}`
/// - effort_share: Share of the limits of effort and power that the computed torque may use [default: 0.9]
/// - friction: Friction terms of every joint in the later identification. The words and the default are those of
///   friction= of `rist identify`; auto is not possible
/// - criterion: What the search of the motion optimises [default: 'determinant']
/// - noise: Standard deviation of the noise of a torque sample, as a share of the effort limit [default: 0.01]
/// - starts: Number of starts of the search. A third of them are random; the others begin near the best motion so
///   far [default: 12]
/// - iterations: Maximum number of iterations of each start, at each weight of the barrier function for the
///   limits [default: 100]
/// - seed: Seed of the random starts; the same seed gives the same motion [default: 1]
/// - after: The motion excites the parameters that this estimate leaves uncertain
/// - progress: Called with (done, all, text) during the work
#[pyfunction]
#[pyo3(signature = (model, **options), text_signature = "(model, *, motion='fourier', period=None, frequency=None, harmonics=None, spans=None, repetitions=3, blend=None, rate=200.0, limits=None, effort_share=0.9, friction=None, criterion='determinant', noise=0.01, starts=12, iterations=100, seed=1, after=None, progress=None)")]
pub fn excite(
    py: Python<'_>,
    model: &Bound<'_, PyAny>,
    options: Option<&Bound<'_, PyDict>>,
) -> PyResult<ExcitingMotion> {
    let model = Model::of(model)?;
    let known = &model.get().inner;
    let call = Call::new("excite", &["after", "progress"], options)?;
    let request = ExciteRequest { after: estimate_of(&call, "after")?, ..call.request()? };
    let inner = work(py, call.own("progress"), |reporter| {
        rist::excite(known, &request, &|done, all, text| reporter.tell(done, all, text))
    })?;
    Ok(ExcitingMotion { inner, model: Some(model.unbind()) })
}

/// Proves again that a motion keeps its limits, and also the limits in `limits` (a path to YAML, or its content as a dict). The
/// torques follow from the description, or from the estimate `after`. Of a plan, each experiment is proved in this way, and the
/// efficiency that the proof of the plan guarantees is computed again. Returns a list of faults. The list is empty if every
/// checked limit is proven, and every check that `limits` asks for was possible.
///
/// model: a Model, or the path of a description. motion: an ExcitingMotion, an ExperimentPlan, or the path of a file: of a
/// motion, a plan, a table of points (CSV) or a JointTrajectory (YAML, JSON).
///
/// Options:
/// - limits: YAML with further limits that the motion must keep, in the form of limits= of `rist excite`. A limit
///   that is not in this file is not assumed. A check is left out (`space: {floor: none, accept: ..}`) only if
///   this file says so
/// - after: The torques in the proofs of effort and power follow from this estimate
/// - interpolation: How the controller interpolates between the points of a table or a JointTrajectory [default:
///   the smoothest way that the points allow]
#[pyfunction]
#[pyo3(signature = (model, motion, **options), text_signature = "(model, motion, *, limits=None, after=None, interpolation=None)")]
pub fn check(
    py: Python<'_>,
    model: &Bound<'_, PyAny>,
    motion: &Bound<'_, PyAny>,
    options: Option<&Bound<'_, PyDict>>,
) -> PyResult<Vec<String>> {
    let model = Model::of(model)?;
    let model = &model.get().inner;
    let call = Call::new("check", &["after", "interpolation"], options)?;
    let asked = CheckRequest { after: estimate_of(&call, "after")?, ..call.request()? };
    let interpolation = call.own("interpolation").map(interpolation_of).transpose()?;
    let path: PathBuf = motion.extract().unwrap_or("motion".into());
    let file = match (motion.cast::<ExcitingMotion>(), motion.cast::<ExperimentPlan>()) {
        (Ok(motion), _) => PlayedFile::Motion(Box::new(motion.get().inner.clone())),
        (_, Ok(plan)) => PlayedFile::Plan(Box::new(plan.get().inner.clone())),
        _ if motion.extract::<PathBuf>().is_ok() => PlayedFile::read(model, &path).or_error()?,
        _ => return Err(error("check: a motion is an ExcitingMotion, an ExperimentPlan, or the path of a file")),
    };
    Ok(alone(py, || file.check(model, &path, interpolation, &asked))?.or_error()?.faults())
}

/// The interpolation with this name. Fails with a list of the names if it is unknown.
fn interpolation_of(given: &Bound<'_, PyAny>) -> PyResult<Interpolation> {
    let word: String = given.extract().unwrap_or_default();
    let found = Interpolation::ALL.into_iter().find(|(_, known)| *known == word);
    found.map(|(interpolation, _)| interpolation).ok_or_else(|| {
        let words: Vec<&str> = Interpolation::ALL.iter().map(|(_, word)| *word).collect();
        error(format_args!("check: interpolation is one of {}", words.join(", ")))
    })
}
