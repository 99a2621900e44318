//! `rist.identify` and `rist.doctor`: logs -> parameters, or what is wrong with them.

use std::path::PathBuf;

use identification::estimate::options::Options;
use identification::estimators::drive_gains::likelihood::Gain;
use identification::estimators::weighted::Weights;
use identification::signals::signal_options::possible_delay;
use identification::spectrum::identify::SpectralMethod;
use linear_model::friction::terms::FrictionTerm;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rist::IdentifyRequest;
use rist::experiments::ExperimentLogs;
use rist::request::harmonic_request::Delay;

use crate::effects::{joint_effects, refuse_effects};
use crate::error::{OrError, error};
use crate::estimate::Estimate;
use crate::experiments::{ExperimentPlan, gains, read_load};
use crate::html;
use crate::keywords::Keywords;
use crate::logs::{logs, open};
use crate::model::Model;
use crate::work::work;

/// Options of `identify`, as of the program.
const OPTIONS: [&str; 19] = [
    "cutoff",
    "order",
    "decimate",
    "delay",
    "friction",
    "weights",
    "options",
    "gain",
    "consistent",
    "covariance",
    "loaded",
    "loaded_link",
    "method",
    "plan",
    "load",
    "validate",
    "ripple",
    "elastic",
    "play",
];

/// The options that an identification from experiments ignores and therefore refuses.
const OF_SAMPLES: [&str; 9] =
    ["order", "decimate", "friction", "weights", "consistent", "covariance", "loaded", "loaded_link", "validate"];

/// Identifies the base parameters and the friction of a robot from logs of it.
///
/// logs: one or a list; each a path (CSV, .npz, Parquet, MCAP, a rosbag2 directory), a dict of arrays ({"t": (N,),
/// "q": (N, n), "tau": (N, n)}; SI), or a table with __arrow_c_stream__ (pandas, polars, pyarrow). With method="rist" or
/// "rist-mh": the directory of the logs of `plan`.
///
/// Options, as of `rist identify --help`: cutoff (Hz), order, decimate, delay (s, or "auto"), friction ("viscous,coulomb" or
/// a list; "auto"; "none"), weights ("none", "joint", "huber", ..), gain ({"q5": 11.0} or {"q5": (11.0, 2.0)} for an
/// expected one, N m/A), consistent (only bodies that can exist), covariance (keep it), loaded and loaded_link (logs with a
/// load), validate (logs that are predicted, not fitted, for the verdict), options (a path to YAML, or its text, with any
/// option of an identification), method, plan, load.
///
/// With method="rist-mh" it also estimates, where asked: ripple (periods a turn of all joints, or {"q2": 12}, or
/// {"q2": [6, 12]}), elastic and play (True for all joints, or ["q2", "q3"]: springs and gaps behind the motors, which have
/// the encoders; the equations end at 10 Hz then, unless cutoff says otherwise), delay="auto". cutoff: highest frequency of
/// the equations (20 Hz).
///
/// Ctrl-C ends it. Raises rist.Error with the message of the program.
#[pyfunction]
#[pyo3(signature = (model, logs, **options), text_signature = "(model, logs, *, cutoff=None, order=None, decimate=None, delay=None, friction=None, weights=None, gain=None, consistent=False, covariance=False, loaded=(), loaded_link=None, validate=(), options=None, method='ls', plan=None, load=None, ripple=None, elastic=False, play=False)")]
pub fn identify(
    py: Python<'_>,
    model: &Bound<'_, Model>,
    logs: &Bound<'_, PyAny>,
    options: Option<&Bound<'_, PyDict>>,
) -> PyResult<Estimate> {
    let given = Keywords::new("identify", &OPTIONS, options)?;
    let methods = [
        ("ls", Method::LeastSquares),
        ("essential", Method::Essential),
        ("rist", Method::Experiments(SpectralMethod::Paper)),
        ("rist-mh", Method::Experiments(SpectralMethod::Harmonic)),
    ];
    match given.word("method", &methods)?.unwrap_or(Method::LeastSquares) {
        Method::LeastSquares => identify_samples(py, model, logs, &given, false),
        Method::Essential => identify_samples(py, model, logs, &given, true),
        Method::Experiments(method) => identify_experiments(py, model, logs, &given, method),
    }
}

/// How an identification is done.
#[derive(Clone, Copy)]
enum Method {
    LeastSquares,
    /// Least squares with only the parameters that the data can distinguish from zero.
    Essential,
    Experiments(SpectralMethod),
}

fn identify_samples(
    py: Python<'_>,
    model: &Bound<'_, Model>,
    fitted: &Bound<'_, PyAny>,
    given: &Keywords<'_>,
    essential: bool,
) -> PyResult<Estimate> {
    if let Some(other) = given.given(&["plan", "load"]).first() {
        return Err(error(format_args!("identify: {other} is for method='rist' and 'rist-mh'")));
    }
    refuse_effects(&joint_effects(given)?)?;
    let inner = &model.get().inner;
    let mut options = options_of_samples(given, inner)?;
    options.covariance |= given.get("covariance", "True or False")?.unwrap_or(false);
    let (find_delay, find_friction) = (is_auto(given, "delay"), is_auto(given, "friction"));
    let empty = pyo3::types::PyList::empty(py).into_any();
    let of = |name: &str| logs(given.any(name).unwrap_or(&empty));
    let (fitted, loaded, others) = (logs(fitted)?, of("loaded")?, of("validate")?);
    if fitted.is_empty() {
        return Err(error("identify: no log is given"));
    }
    let mut paths: Vec<PathBuf> = Vec::new();
    for path in fitted.iter().chain(&loaded).chain(&others).filter_map(|log| log.path()) {
        if paths.iter().any(|other| rist::output::is_same(path, other)) {
            return Err(error(format_args!("{}: given twice; a log counts once, in one role", path.display())));
        }
        paths.push(path.into());
    }
    let gains = expected_gains(given)?;
    let loaded_link = given.get("loaded_link", "the name of a link")?;
    let consistent = given.get("consistent", "True or False")?.unwrap_or(false);
    let (found, verdict) = work(py, None, |_| {
        let columns = options.columns.clone();
        let (fitted, loaded) = (open(fitted, inner, &columns)?, open(loaded, inner, &columns)?);
        let others = open(others, inner, &columns)?;
        let loaded = &loaded;
        let request =
            IdentifyRequest { options, gains, find_delay, find_friction, consistent, essential, loaded, loaded_link };
        let mut found = rist::identify(inner, &fitted, &request)?;
        let predictions = rist::validation::predictions(inner, &found.estimate, &others)?;
        let verdict = found.judge(predictions.iter().map(|(_, p)| p.total).reduce(f64::max));
        Ok((found, verdict))
    })?;
    Ok(Estimate {
        inner: found.estimate,
        model: Some(model.clone().unbind()),
        verdict,
        bodies: found.bodies,
        load: found.load.map(|load| load.to_string().trim().to_string()),
        findings: found.passport.findings.iter().map(ToString::to_string).collect(),
        is_read: false,
    })
}

fn identify_experiments(
    py: Python<'_>,
    model: &Bound<'_, Model>,
    directory: &Bound<'_, PyAny>,
    given: &Keywords<'_>,
    method: SpectralMethod,
) -> PyResult<Estimate> {
    let unheeded = given.given(&OF_SAMPLES);
    if !unheeded.is_empty() {
        let unheeded = unheeded.join(", ");
        return Err(error(format_args!(
            "identify: {unheeded}: for logs, not for the experiments of a plan (method='ls')"
        )));
    }
    let directory: PathBuf =
        directory.extract().map_err(|_| error("identify: with a plan, logs is the directory of its logs"))?;
    let inner = &model.get().inner;
    let Some(plan) = given.any("plan") else {
        return Err(error("identify: method='rist' and 'rist-mh' need the plan behind the logs: plan="));
    };
    let plan = ExperimentPlan::of(plan, inner)?;
    let columns = read_options(given)?.columns;
    let load = match given.get::<PathBuf>("load", "a path")? {
        Some(path) => Some((path.clone(), read_load(&path)?)),
        None => None,
    };
    let mut asked = joint_effects(given)?;
    if method == SpectralMethod::Paper {
        if !given.given(&["cutoff", "delay"]).is_empty() {
            return Err(error("identify: cutoff and delay: the paper's rows have neither; method='rist-mh' has both"));
        }
        refuse_effects(&asked)?;
    }
    asked.cutoff = given.get("cutoff", "a number of Hz")?;
    asked.delay = match is_auto(given, "delay") {
        true => Some(Delay::Auto),
        false => given.get("delay", "'auto', or seconds")?.map(Delay::Seconds),
    };
    let options = asked.options(inner).map_err(|e| error(format_args!("identify: {e}")))?;
    let gains = gains(given, "gain", inner)?;
    let estimate = work(py, None, |_| {
        let logs = ExperimentLogs { directory: &directory, plan: &plan, columns, gains, load, options };
        rist::identify_experiments(inner, &logs, method)
    })?;
    Ok(Estimate::plain(estimate, Some(model.clone().unbind())))
}

/// The options that estimates from samples and from sums share. The word auto leaves the default in place.
pub fn options_of_samples(given: &Keywords<'_>, model: &rist::Model) -> PyResult<Options> {
    let mut options = read_options(given)?;
    options.model = model.robot.name.clone();
    let signal = &mut options.signal;
    signal.cutoff = given.get("cutoff", "a number of Hz")?.or(signal.cutoff);
    signal.order = given.get("order", "a whole number")?.unwrap_or(signal.order);
    signal.decimate = given.get("decimate", "a whole number")?.or(signal.decimate);
    if signal.decimate == Some(0) {
        return Err(error("decimate=0: a whole number from 1 is expected"));
    }
    if !is_auto(given, "delay")
        && let Some(delay) = given.get::<f64>("delay", "'auto', or seconds between -1 and 1")?
    {
        signal.delay = possible_delay(delay).map_err(error)?;
    }
    options.weights = given.word("weights", &Weights::ALL.map(|w| (w.word(), w)))?.unwrap_or(options.weights);
    if !is_auto(given, "friction")
        && let Some(words) = friction(given)?
    {
        options.friction = words;
    }
    Ok(options)
}

/// The options of an identification: of a file, of a text of YAML, or the customary ones.
fn read_options(given: &Keywords<'_>) -> PyResult<Options> {
    match given.any("options") {
        None => Ok(Options::default()),
        Some(text) => match text.extract::<String>() {
            Ok(text) if text.contains(':') => Options::parse("options", &text).or_error(),
            _ => Options::read(&given.get::<PathBuf>("options", "a path, or a text of YAML")?.unwrap_or_default())
                .or_error(),
        },
    }
}

/// Whether the option is "auto", so that the program finds the value.
pub fn is_auto(given: &Keywords<'_>, name: &str) -> bool {
    given.any(name).and_then(|x| x.extract::<String>().ok()).is_some_and(|word| word == "auto")
}

/// Words in a text, or in a list.
pub fn friction(given: &Keywords<'_>) -> PyResult<Option<Vec<FrictionTerm>>> {
    let Some(value) = given.any("friction") else { return Ok(None) };
    let words: Vec<String> = match value.extract::<String>() {
        Ok(text) => text.split(',').map(|word| word.trim().to_string()).collect(),
        Err(_) => {
            given.get("friction", "words such as 'viscous,coulomb,offset', or a list of them")?.unwrap_or_default()
        }
    };
    if words == ["none"] {
        return Ok(Some(Vec::new()));
    }
    if let Some(word) = (1..words.len()).find(|&i| words[..i].contains(&words[i])) {
        return Err(error(format_args!("identify: friction: {} stands there twice", words[word])));
    }
    if words.iter().any(|word| word == "auto" || word == "none") {
        return Err(error("identify: friction: auto and none stand alone"));
    }
    let term = |word: &String| FrictionTerm::of_word(word).map_err(|e| error(format_args!("identify: friction: {e}")));
    words.iter().map(term).collect::<PyResult<_>>().map(Some)
}

/// Known gains as numbers, expected ones as (value, deviation).
fn expected_gains(given: &Keywords<'_>) -> PyResult<Vec<(String, Gain)>> {
    let wrong =
        || error("identify: gain={'q1': 2.393} is expected, or {'q5': (11.0, 2.0)} for one near 11, positive, N m/A");
    let Some(gains) = given.any("gain") else { return Ok(Vec::new()) };
    let is_positive = |x: &f64| x.is_finite() && *x > 0.0;
    let mut found = Vec::new();
    for (name, value) in gains.cast::<PyDict>().map_err(|_| wrong())? {
        let gain = match (value.extract::<f64>(), value.extract::<(f64, f64)>()) {
            (Ok(gain), _) if is_positive(&gain) => Gain::Known(gain),
            (_, Ok((gain, deviation))) if is_positive(&gain) && is_positive(&deviation) => {
                Gain::Expected(gain, deviation)
            }
            _ => return Err(wrong()),
        };
        found.push((name.extract()?, gain));
    }
    Ok(found)
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
            table: passport.to_string(),
            findings: passport.findings.iter().map(ToString::to_string).collect(),
            untold: passport.untold.clone(),
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
/// logs as of `identify`; options: a path to YAML with any option of an identification, or its text.
#[pyfunction]
#[pyo3(signature = (model, logs, **options), text_signature = "(model, logs, *, options=None)")]
pub fn doctor(
    py: Python<'_>,
    model: &Model,
    logs: &Bound<'_, PyAny>,
    options: Option<&Bound<'_, PyDict>>,
) -> PyResult<Passport> {
    let options = read_options(&Keywords::new("doctor", &["options"], options)?)?;
    let given = crate::logs::logs(logs)?;
    let inner =
        work(py, None, |_| rist::examine(&model.inner, &open(given, &model.inner, &options.columns)?, &options))?;
    Ok(Passport::of(&inner))
}
