//! `rist.identify` and `rist.doctor`: logs -> parameters, or what is wrong with them.

use std::path::PathBuf;

use pyo3::prelude::*;
use pyo3::types::PyDict;
use rist::ClosedLoop;
use rist::closed_loop::identify_experiments_in_loop;
use rist::doctor::DoctorRequest;
use rist::experiments::{ExperimentLogs, identify_gains_of_rows, identify_paper_rows};
use rist::request::spelling::{Reader, spelled};
use rist::request::{IdentifyRequest, Method, MethodRequest, Words};
use rist::samples::{identify_essential, identify_loaded};

use crate::call::Call;
use crate::error::{OrError, all_spelled, error};
use crate::estimate::Estimate;
use crate::experiments::ExperimentPlan;
use crate::html;
use crate::logs::{logs, open};
use crate::model::Model;
use crate::work::work;

/// Identifies the base parameters and the friction of a robot from logs of it.
///
/// logs: one or a list; each a path (CSV, .npz, Parquet, MCAP, a rosbag2 directory), a dict of arrays ({"t": (N,),
/// "q": (N, n), "tau": (N, n)}; SI), or a table with __arrow_c_stream__ (pandas, polars, pyarrow). With method="rist",
/// "rist-mh", "iv" or "didim": the directory of the logs of `plan`.
///
/// Options:
/// - consistent: Physically consistent parameters: only bodies that can exist. Where the log says nothing, they
///   stay near the bodies of the description [default: False]
/// - gain: Torque per unit of current of a drive, N m/A [default: as the file says]. Where only some drives are
///   given, the others are estimated; q5=11+-2 expects a gain near 11
/// - covariance: Keep the covariance of the parameters in the estimate [default: False]
/// - loaded_link: The link that carries the load of the logs with a load [default: the last]
/// - friction: Friction columns per joint: viscous, coulomb, offset, asymmetric, load, rotor, smooth-coulomb=V,
///   stribeck=V (V in rad/s), none, or auto, the set that best predicts parts of the logs left out of the fit
///   [default: viscous,coulomb,offset]
/// - weights: What rows weigh [default: joint]
/// - cutoff: Cut-off of the zero-phase low-pass, Hz [default: by the frequency content of the logs]
/// - order: Order of the Butterworth filter, 0 for none [default: 4]
/// - decimate: Keep every N-th filtered sample [default: by the cut-off]
/// - delay: Seconds by which the torques lag the positions, negative where they come before [default: 0]; or
///   auto: the delay, up to a quarter of a second to both sides, with the smallest residual on rows away from
///   reversals of their joint. The residual of all rows may be larger with it than without
/// - options: YAML with any option of an identification; other options override it
/// - load: A known load: YAML with link, mass (kg), centre_of_mass (m) and inertia about it (kg m^2). The logs of
///   the experiments repeated with it, e01_loaded.csv, .., stand beside the others; no gain need be known
/// - ripple: Estimate ripple of torque and gain with so many periods a turn, of a coordinate or of all
/// - elastic: Estimate the springs of these coordinates, or of all; the encoders are at the motors. The equations
///   end at 10 Hz then, unless cutoff= says otherwise [default: False]
/// - backlash: Estimate the backlash of these joints, or of all, as elastic= does springs [default: False]
/// - method: The equations to solve; all but ls and essential need the plan behind the logs [default: 'ls']
/// - loaded: Logs with a load on the last link, which is identified too
/// - validate: Logs that are predicted, not fitted, for the verdict
/// - plan: The plan behind the logs
///
/// With method="rist-mh" it also estimates, where asked: ripple (periods a turn of all joints, or {"q2": 12}, or
/// {"q2": [6, 12]}), elastic and backlash (True for all joints, or ["q2", "q3"]: springs and gaps behind the motors, which have
/// the encoders; the equations end at 10 Hz then, unless cutoff says otherwise), delay="auto". cutoff: highest frequency of
/// the equations (20 Hz).
///
/// Ctrl-C ends it. Raises rist.Error with the message of the program.
#[pyfunction]
#[pyo3(signature = (model, logs, **options), text_signature = "(model, logs, *, consistent=False, gain=None, covariance=False, loaded_link=None, friction=None, weights=None, cutoff=None, order=None, decimate=None, delay=None, options=None, load=None, ripple=None, elastic=False, backlash=False, method='ls', loaded=(), validate=(), plan=None)")]
pub fn identify(
    py: Python<'_>,
    model: &Bound<'_, Model>,
    logs: &Bound<'_, PyAny>,
    options: Option<&Bound<'_, PyDict>>,
) -> PyResult<Estimate> {
    let own = &["method", "plan", "loaded", "validate"];
    let call = Call::new("identify", own, options)?;
    let MethodRequest { method } = Call::only("identify", "method", options)?.request()?;
    call.check_method(method)?;
    match method {
        Method::Ls | Method::Essential => identify_samples(py, model, logs, &call, method),
        Method::Rist | Method::Tls | Method::RistMh | Method::Iv | Method::Didim => {
            identify_plan(py, model, logs, &call, method)
        }
    }
}

fn identify_samples(
    py: Python<'_>,
    model: &Bound<'_, Model>,
    fitted: &Bound<'_, PyAny>,
    call: &Call<'_>,
    method: Method,
) -> PyResult<Estimate> {
    let inner = &model.get().inner;
    let request = match method {
        Method::Essential => IdentifyRequest { samples: call.request()?, ..IdentifyRequest::default() },
        _ => call.request()?,
    };
    let empty = pyo3::types::PyList::empty(py).into_any();
    let of = |name: &str| logs(call.own(name).unwrap_or(&empty));
    let (fitted, loaded, others) = (logs(fitted)?, of("loaded")?, of("validate")?);
    if fitted.is_empty() {
        return Err(error("identify: no log is given"));
    }
    // A log counts once, in one role.
    let mut paths: Vec<PathBuf> = Vec::new();
    for path in fitted.iter().chain(&loaded).chain(&others).filter_map(|log| log.path()) {
        if paths.iter().any(|other| rist::output::is_same(path, other)) {
            return Err(error(format_args!("{}: given twice; a log counts once, in one role", path.display())));
        }
        paths.push(path.into());
    }
    // In a thread of its own, from the files to the verdict.
    let (found, judged) = work(py, None, |_| {
        let columns = request.samples.options().columns;
        let (fitted, loaded) = (open(fitted, inner, &columns)?, open(loaded, inner, &columns)?);
        let others = open(others, inner, &columns)?;
        let mut found = match method {
            Method::Essential => identify_essential(inner, &fitted, &loaded, &request.samples)?,
            _ => identify_loaded(inner, &fitted, &loaded, &request)?,
        };
        let judged = found.judged(inner, &others, false)?;
        Ok((found, judged))
    })?;
    // The model of the estimate, which may have rotors that the given one lacks.
    let used = match found.model {
        Some(used) => Py::new(py, model.get().read_as(used))?,
        None => model.clone().unbind(),
    };
    Ok(Estimate {
        inner: found.estimate,
        model: Some(used),
        verdict: judged.verdict.into(),
        bodies: found.bodies,
        load: found.load.map(|load| load.to_string().trim().to_string()),
        findings: found.passport.findings.iter().map(ToString::to_string).collect(),
        is_read: false,
    })
}

fn identify_plan(
    py: Python<'_>,
    model: &Bound<'_, Model>,
    directory: &Bound<'_, PyAny>,
    call: &Call<'_>,
    method: Method,
) -> PyResult<Estimate> {
    let directory: PathBuf =
        directory.extract().map_err(|_| error("identify: with a plan, logs is the directory of its logs"))?;
    let inner = &model.get().inner;
    let Some(plan) = call.own("plan") else {
        let method = method.word();
        return Err(error(format_args!("identify: [method={method}] needs the plan behind the logs: [plan]")));
    };
    let plan = ExperimentPlan::of(plan, inner)?;
    let logs = ExperimentLogs { directory: &directory, plan: &plan };
    // IV and DIDIM simulate the closed loop; all others need the logs only.
    let in_loop = |method| {
        let request = call.request()?;
        work(py, None, |_| identify_experiments_in_loop(inner, logs, &request, method))
    };
    let estimate = match method {
        Method::Iv => in_loop(ClosedLoop::InstrumentalVariables)?,
        Method::Didim => in_loop(ClosedLoop::DirectAndInverse)?,
        Method::Rist | Method::Tls => {
            let request = call.request()?;
            let identify = if method == Method::Tls { identify_gains_of_rows } else { identify_paper_rows };
            work(py, None, |_| identify(inner, logs, &request))?
        }
        Method::RistMh | Method::Ls | Method::Essential => {
            let request = call.request()?;
            work(py, None, |_| rist::identify_experiments(inner, logs, &request))?
        }
    };
    Ok(Estimate::plain(estimate, Some(model.clone().unbind())))
}

/// What logs and a description have to do with each other.
#[pyclass(frozen, module = "rist")]
pub struct Passport {
    /// One line a joint.
    table: String,
    findings: Vec<String>,
    untold: Vec<String>,
    is_gross: bool,
}

impl Passport {
    fn of(passport: &rist::doctor::Passport) -> Passport {
        Passport {
            table: spelled(&passport.to_string(), Reader::Python),
            findings: passport.findings.iter().map(|finding| spelled(&finding.to_string(), Reader::Python)).collect(),
            untold: all_spelled(&passport.untold),
            is_gross: passport.is_gross(),
        }
    }
}

#[pymethods]
impl Passport {
    /// What is wrong, the worst first: a sentence each with what mends it.
    #[getter]
    fn findings(&self) -> Vec<String> {
        self.findings.clone()
    }

    /// What could not be looked at.
    #[getter]
    fn untold(&self) -> Vec<String> {
        self.untold.clone()
    }

    /// Whether a finding forbids to use an estimate from these logs.
    #[getter]
    fn is_gross(&self) -> bool {
        self.is_gross
    }

    fn __repr__(&self) -> String {
        let lines = [self.findings(), self.untold()].concat().join("\n");
        format!("{}\n{lines}", self.table)
    }

    fn _repr_html_(&self) -> String {
        html::text(&self.__repr__())
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, PassportState)> {
        let state = (self.table.clone(), self.findings(), self.untold(), self.is_gross);
        Ok((py.import("rist")?.getattr("_passport")?, state))
    }
}

/// A passport as a pickle holds it.
type PassportState = (String, Vec<String>, Vec<String>, bool);

/// What a pickle of a passport calls.
#[pyfunction]
pub fn _passport(table: String, findings: Vec<String>, untold: Vec<String>, is_gross: bool) -> Passport {
    Passport { table, findings, untold, is_gross }
}

/// Looks for what is wrong with logs before anything is fitted: units, signs, zeros, swapped columns, another robot.
///
/// logs as of `identify`; options: a path to YAML with any option of an identification, its text, or its content as a
/// dict; gain: {"q1": 2.393}, N m/A.
///
/// Options:
/// - options: YAML with any option of an identification
/// - gain: Torque per unit of current of a drive, N m/A [default: as the file says]
#[pyfunction]
#[pyo3(signature = (model, logs, **options), text_signature = "(model, logs, *, options=None, gain=None)")]
pub fn doctor(
    py: Python<'_>,
    model: &Model,
    logs: &Bound<'_, PyAny>,
    options: Option<&Bound<'_, PyDict>>,
) -> PyResult<Passport> {
    let request: DoctorRequest = Call::new("doctor", &[], options)?.request()?;
    let options = request.options(&model.inner).or_error()?;
    let given = crate::logs::logs(logs)?;
    let inner =
        work(py, None, |_| rist::examine(&model.inner, &open(given, &model.inner, &options.columns)?, &options))?;
    Ok(Passport::of(&inner))
}
