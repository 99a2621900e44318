//! The functions `rist.identify` and `rist.doctor`: identify parameters from logs, and check logs.
//!
//! The state of an object is the content of its pickle.

use std::path::PathBuf;

use pyo3::prelude::*;
use pyo3::types::PyDict;
use rist::fit::doctor::{DoctorRequest, claims_of_log};
use rist::fit::experiments::{ExperimentLogs, identify_gains_of_rows, identify_paper_rows};
use rist::fit::samples::{identify_essential, identify_loaded};
use rist::fit::verdict::claim_line;
use rist::identify_experiments_in_loop;
use rist::request::{IdentifyRequest, Method, MethodRequest, WordChoice};

use crate::artefact::hash;
use crate::call::Call;
use crate::error::{OrError, all_spelled, error, for_python, renamed, warn_of};
use crate::estimate::Estimate;
use crate::html;
use crate::logs::{logs, open};
use crate::model::Model;
use crate::motions::ExperimentPlan;
use crate::work::work;

/// Identifies the base parameters and the friction of a robot from its logs. If the verdict is no, a rist.TrustWarning says so.
///
/// model: a Model, or the path of a description. logs: one log or a list of logs. A log is a path (CSV, .npz, Arrow, Parquet,
/// MCAP, a rosbag2 directory), a dict of arrays ({"t": (N,), "q": (N, n), "tau": (N, n)}; SI units), or a table with
/// __arrow_c_stream__ (pandas, polars, pyarrow). With method="rist", "tls", "rist-mh", "iv" or "didim", logs is the directory
/// with the logs of `plan`.
///
/// Options:
/// - consistent: Identify physically consistent parameters: every link is a body that can exist. A body that the
///   logs do not determine stays near the body of the description [default: False]
/// - free_bodies: Never constrain the links to bodies that can exist. Without this option, the links are
///   constrained if a log is poor and held-out parts of it are then predicted better [default: False]
/// - gain: Drive gain (torque per current), N m/A [default: as in the file]. If only some gains are given, the
///   others are estimated. q5=11+-2: a gain near 11 is expected, with standard deviation 2
/// - arm: A hobby arm or its servo: so101, koch, wx250s, vx300s, openmanipulator-x, xm430-w350 and others. Units,
///   zeros and gains of this arm are used where nothing else gives them. The form of the positions may follow the
///   name: so101:degrees, :normalised, :counts or :radians
/// - unknowns: What to identify in addition to the parameters, for all joints: mount (of the base), zeros (of the
///   positions), scales (of the torques), springs. The estimate gives each value with its deviation, and the
///   option or the line of the URDF that corrects it
/// - leave_out_contact: Leave out the rows of intervals in which the residual is an outlier, for example during a
///   contact. The estimate lists these intervals [default: False]
/// - covariance: Keep the covariance of the parameters in the estimate [default: False]
/// - loaded_link: The link that carries the load in the logs of loaded= [default: the last link]
/// - friction: Friction terms of every joint: viscous, coulomb, offset, asymmetric, load, rotor,
///   smooth-coulomb=V, stribeck=V (V in rad/s), none; or auto, which chooses the terms that best predict held-out
///   parts of the logs [default: viscous,coulomb,offset]
/// - weights: Weights of the rows in the fit [default: joint]
/// - cutoff: Cut-off of the zero-phase low-pass, Hz [default: from the frequency content of the logs]
/// - order: Order of the Butterworth low-pass; 0: no low-pass [default: 4]
/// - rate: Rows per second (Hz) of a log without a clock
/// - decimate: Keep every N-th filtered sample [default: from the cut-off]
/// - delay: Delay of the torques behind the positions, s; negative if the torques come first [default: 0]. auto:
///   the delay within +-0.25 s with the smallest residual, on rows away from reversals of their joint. With this
///   delay, the residual of all rows may be larger than without
/// - options: YAML with any option of an identification. Other options that are given here replace those of the
///   file
/// - load: A known load: YAML with link, mass (kg), centre_of_mass (m) and inertia about the centre of mass (kg
///   m^2). The logs of the experiments with the load, e01_loaded.csv, .., are in the folder of the other logs.
///   With a load, no gain needs to be known
/// - ripple: Estimate ripple of torque and gain with this number of periods per turn of the joint, for one
///   coordinate or for all
/// - spring: Estimate a spring in parallel with the motor, for example one that balances gravity, for these
///   coordinates or for all [default: False]
/// - eccentric: Estimate the error that an encoder has once per turn, for these coordinates or for all [default:
///   False]
/// - elastic: Estimate a spring between motor and link, for these coordinates or for all. It is assumed that the
///   encoders are at the motors. The equations then end at 10 Hz, unless cutoff= is given [default: False]
/// - backlash: Estimate the backlash between motor and link, for these coordinates or for all. The assumption and
///   the equations are as for elastic= [default: False]
/// - method: Method of identification. All methods except ls and essential need plan=, the plan whose experiments
///   are in the logs [default: 'ls']
/// - loaded: Logs with a load on the last link; the load is identified too
/// - validate: Logs that are not fitted, but predicted, for the verdict
/// - plan: The plan whose experiments are in the logs
/// - rotor_inertia: Joints that have a rotor inertia (IA) among their parameters [default: as in the file; if the
///   file says nothing: actuated for YAML, none for URDF]
///
/// With method="rist-mh", you can also estimate: ripple (periods per turn of all joints, or {"q2": 12}, or {"q2": [6, 12]});
/// elastic and backlash (True for all joints, or ["q2", "q3"]: springs and gaps between the motors, which have the encoders,
/// and the links); delay="auto". With elastic or backlash, the equations end at 10 Hz, unless cutoff is given. cutoff is the
/// highest frequency of the equations (default 20 Hz).
///
/// Ctrl-C ends the identification. If something is wrong, raises rist.Error with the message of the program.
#[pyfunction]
#[pyo3(signature = (model, logs, **options), text_signature = "(model, logs, *, consistent=False, free_bodies=False, gain=None, arm=None, unknowns=None, leave_out_contact=False, covariance=False, loaded_link=None, friction=None, weights=None, cutoff=None, order=None, rate=None, decimate=None, delay=None, options=None, load=None, ripple=None, spring=False, eccentric=False, elastic=False, backlash=False, method='ls', loaded=(), validate=(), plan=None, rotor_inertia=None)")]
pub fn identify(
    py: Python<'_>,
    model: &Bound<'_, PyAny>,
    logs: &Bound<'_, PyAny>,
    options: Option<&Bound<'_, PyDict>>,
) -> PyResult<Estimate> {
    let own = &["method", "plan", "loaded", "validate", "rotor_inertia"];
    let call = Call::new("identify", own, options)?;
    let MethodRequest { method } = Call::only("identify", "method", options)?.request()?;
    call.check_method(method)?;
    let mut model = Model::of(model)?;
    if let Some(rotors) = call.own("rotor_inertia") {
        model = Model::with_rotors(&model, rotors)?;
    }
    let estimate = match method {
        Method::Ls | Method::Essential => identify_samples(py, &model, logs, &call, method),
        Method::Rist | Method::Tls | Method::RistMh | Method::Iv | Method::Didim => {
            identify_plan(py, &model, logs, &call, method)
        }
    }?;
    warn_of(py, &estimate.verdict.inner)?;
    Ok(estimate)
}

fn identify_samples(
    py: Python<'_>,
    model: &Bound<'_, Model>,
    fitted: &Bound<'_, PyAny>,
    call: &Call<'_>,
    method: Method,
) -> PyResult<Estimate> {
    let inner = &model.get().inner;
    let mut request = match method {
        Method::Essential => IdentifyRequest { samples: call.request()?, ..IdentifyRequest::default() },
        _ => call.request()?,
    };
    let empty = pyo3::types::PyList::empty(py).into_any();
    let of = |name: &str| logs(call.own(name).unwrap_or(&empty));
    let given = fitted.clone().unbind();
    let (fitted, loaded, others) = (logs(fitted)?, of("loaded")?, of("validate")?);
    if fitted.is_empty() {
        return Err(error("identify: no log is given"));
    }
    rist::output::check_given_once(fitted.iter().chain(&loaded).chain(&others).filter_map(|log| log.path()))
        .or_error()?;
    request.samples = request.samples.with_arm(&inner.robot, fitted.iter().find_map(|log| log.path())).or_error()?.0;
    // All work from reading files to the verdict runs on a thread without the interpreter lock.
    let (found, judged) = work(py, None, |_| {
        let columns = request.samples.options().columns;
        let (fitted, loaded) = (open(fitted, inner, &columns)?, open(loaded, inner, &columns)?);
        let others = open(others, inner, &columns)?;
        let mut found = match method {
            Method::Essential => identify_essential(inner, &fitted, &loaded, &request.samples)?,
            _ => identify_loaded(inner, &fitted, &loaded, &request)?,
        };
        let judged = found.verdict_of_logs(inner, &others, false)?;
        Ok((found, judged))
    })?;
    // The model of the fit may have rotor inertias that the given model lacks.
    let used = match found.model {
        Some(used) => Py::new(py, model.get().read_as(used))?,
        None => model.clone().unbind(),
    };
    Ok(Estimate {
        verdict: judged.verdict.into(),
        bodies: found.bodies,
        load: found.load.map(|load| load.to_string().trim().to_string()),
        findings: found.log_check.findings.iter().map(ToString::to_string).collect(),
        logs: Some(given),
        validation: judged.validation,
        ..Estimate::plain(found.estimate, Some(used))
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
    // IV and DIDIM simulate the experiments in closed loop. The other methods only need the logs.
    let logs = ExperimentLogs { directory: &directory, plan: &plan };
    let estimate = match method {
        Method::Iv | Method::Didim => {
            let request = call.request()?;
            work(py, None, |_| identify_experiments_in_loop(inner, logs, &request, method))?
        }
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

/// The result of checking that logs belong to a description.
#[pyclass(frozen, module = "rist")]
pub struct LogCheck {
    state: LogCheckState,
}

/// Result of a joint in a pickled log check: coordinate; slope of measured over nominal torque; share of the torque on which the
/// slope is based; share of the torque that is explained; range of motion, rad (m).
type JointState = (String, Option<f64>, Option<f64>, Option<f64>, f64);

/// A log check as it is shown and pickled: text with one line per joint, findings, checks that were not possible, whether a
/// finding is gross (makes estimates unusable), results of the joints, claims.
type LogCheckState = (String, Vec<String>, Vec<String>, bool, Vec<JointState>, Vec<String>);

impl LogCheck {
    fn of(check: &rist::fit::doctor::LogCheck) -> LogCheck {
        let joints = check.joints.iter().map(|j| (j.coordinate.clone(), j.slope, j.share, j.explained, j.range()));
        let claims: Vec<String> = claims_of_log(check, &[]).iter().map(claim_line).collect();
        let state = (
            for_python(&check.to_string()),
            check.findings.iter().map(|finding| for_python(&finding.to_string())).collect(),
            all_spelled(&check.not_checked),
            check.is_gross(),
            joints.collect(),
            all_spelled(&claims),
        );
        LogCheck { state }
    }
}

#[pymethods]
impl LogCheck {
    /// What is wrong, the worst first: for each finding a sentence, with its remedy.
    #[getter]
    fn findings(&self) -> Vec<String> {
        self.state.1.clone()
    }

    /// Checks that were not possible, each with its reason.
    #[getter]
    fn not_checked(&self) -> Vec<String> {
        self.state.2.clone()
    }

    /// The former name of `not_checked`.
    #[getter]
    fn untold(&self, py: Python<'_>) -> PyResult<Vec<String>> {
        renamed(py, "untold is called not_checked")?;
        Ok(self.not_checked())
    }

    /// Whether a finding makes an estimate from these logs unusable.
    #[getter]
    fn is_gross(&self) -> bool {
        self.state.3
    }

    /// All claims that were checked: which are contradicted, which agree and what fault they would have shown, and which cannot
    /// be determined.
    #[getter]
    fn claims(&self) -> Vec<String> {
        self.state.5.clone()
    }

    /// How each joint agrees with the description, a dict of columns: coordinate; slope, the measured torque per torque of the
    /// description; share, the part of the torque on which the slope is based; explained, the part of the torque that is
    /// explained together with rotor, friction and offset; range, the range of motion, rad (m).
    #[getter]
    fn joints<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let (joints, table) = (&self.state.4, PyDict::new(py));
        table.set_item("coordinate", joints.iter().map(|j| j.0.as_str()).collect::<Vec<_>>())?;
        table.set_item("slope", joints.iter().map(|j| j.1).collect::<Vec<_>>())?;
        table.set_item("share", joints.iter().map(|j| j.2).collect::<Vec<_>>())?;
        table.set_item("explained", joints.iter().map(|j| j.3).collect::<Vec<_>>())?;
        table.set_item("range", joints.iter().map(|j| j.4).collect::<Vec<_>>())?;
        Ok(table)
    }

    /// findings, not_checked, is_gross, joints and claims by their names.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let dict = PyDict::new(py);
        dict.set_item("findings", self.findings())?;
        dict.set_item("not_checked", self.not_checked())?;
        dict.set_item("is_gross", self.is_gross())?;
        dict.set_item("joints", self.joints(py)?)?;
        dict.set_item("claims", self.claims())?;
        Ok(dict)
    }

    /// Draws the slope of each joint, which is 1 if log and description agree. Returns axes of matplotlib; without matplotlib,
    /// a rist.Picture.
    fn plot<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("rist._plot")?.call_method1("log_check", (slf,))
    }

    fn __eq__(&self, other: &Bound<'_, LogCheck>) -> bool {
        self.state == other.get().state
    }

    fn __hash__(&self) -> u64 {
        hash(&self.__repr__())
    }

    fn __repr__(&self) -> String {
        let lines = [self.findings(), self.not_checked()].concat().join("\n");
        format!("{}\n{lines}", self.state.0)
    }

    fn _repr_html_(&self) -> String {
        let number = |x: Option<f64>| x.map_or("-".to_string(), |x| format!("{x:.2}"));
        let of = |j: &JointState| vec![j.0.clone(), number(j.1), number(j.2), number(j.3), number(Some(j.4))];
        let head = ["joint", "slope", "share", "explained", "range, rad (m)"];
        let said = [self.findings(), self.not_checked()].concat();
        let said = if self.state.1.is_empty() { [vec!["nothing is contradicted".into()], said].concat() } else { said };
        html::table("log and description", &head, self.state.4.iter().map(of)) + &html::list(&said)
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, (LogCheckState,))> {
        Ok((py.import("rist")?.getattr("_log_check")?, (self.state.clone(),)))
    }
}

/// Rebuilds a check from its pickle.
#[pyfunction]
pub fn _log_check(state: LogCheckState) -> LogCheck {
    LogCheck { state }
}

/// Checks logs for mistakes before anything is fitted: units, signs, zeros, swapped columns, another robot.
///
/// model, logs: as for `identify`. options: a path to YAML with any option of an identification, its text, or its content as a
/// dict. gain: {"q1": 2.393}, N m/A.
///
/// Options:
/// - options: YAML with any option of an identification
/// - gain: Drive gain (torque per current), N m/A; negative if the current counts in the opposite direction
///   [default: as in the file]
/// - arm: A hobby arm or its servo: so101, koch, wx250s, vx300s, openmanipulator-x, xm430-w350 and others. Units,
///   zeros and gains of this arm are used where nothing else gives them. The form of the positions may follow the
///   name: so101:degrees, :normalised, :counts or :radians
/// - rate: Rows per second (Hz) of a log without a clock
#[pyfunction]
#[pyo3(signature = (model, logs, **options), text_signature = "(model, logs, *, options=None, gain=None, arm=None, rate=None)")]
pub fn doctor(
    py: Python<'_>,
    model: &Bound<'_, PyAny>,
    logs: &Bound<'_, PyAny>,
    options: Option<&Bound<'_, PyDict>>,
) -> PyResult<LogCheck> {
    let model = Model::of(model)?;
    let model = model.get();
    let request: DoctorRequest = Call::new("doctor", &[], options)?.request()?;
    let given = crate::logs::logs(logs)?;
    let (request, _) = request.with_arm(&model.inner.robot, given.iter().find_map(|log| log.path())).or_error()?;
    let options = request.options(&model.inner).or_error()?;
    let inner =
        work(py, None, |_| rist::examine(&model.inner, &open(given, &model.inner, &options.columns)?, &options))?;
    Ok(LogCheck::of(&inner))
}
