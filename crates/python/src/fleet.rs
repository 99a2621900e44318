//! `rist.Accumulator` and `rist.compare`: sums over logs. They can be merged, solved and compared without the logs.

use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use fleet::CompareRequest;
use fleet::SumsRequest;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};

use crate::artefact::artefact;
use crate::call::Call;
use crate::error::{OrError, error};
use crate::estimate::Estimate;
use crate::logs::logs;
use crate::model::Model;
use crate::work::{alone, work};

/// Sums over logs of one robot: what a fit needs of the logs, without their rows. `update` adds a log, `merge` adds other sums,
/// and `solve` computes the estimate without the logs.
///
/// All sums that will be merged need the same cut-off (Hz) and the same options: cutoff, order, decimate, delay, friction,
/// weights ("none", "joint"), gain ({"q1": 2.393}, N m/A), options, as for `identify`. A pickle of an accumulator has some
/// kilobytes, so the worker processes of any engine can make accumulators. Merged in any order, the result is the same as from
/// one pass over all logs, up to rounding.
///
/// >>> sums = rist.Accumulator(model, cutoff=10.0)
/// >>> sums.update("monday.mcap").merge(other)
/// >>> estimate = sums.solve()
///
/// Options:
/// - gain: Gain of every drive (torque per current), N m/A [default: as in the description]
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
#[pyclass(frozen, module = "rist")]
pub struct Accumulator {
    model: Py<Model>,
    sums: Mutex<fleet::Accumulator>,
}

impl Accumulator {
    /// Locks the sums, even after a panic in another thread: an update is applied completely or not at all, so the sums are
    /// valid.
    fn sums(&self) -> MutexGuard<'_, fleet::Accumulator> {
        self.sums.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// A copy of the sums. Work without the interpreter lock uses it.
    fn copy(&self) -> fleet::Accumulator {
        self.sums().clone()
    }
}

#[pymethods]
impl Accumulator {
    #[new]
    #[pyo3(signature = (model, **options), text_signature = "(model, *, gain=None, friction=None, weights=None, cutoff=None, order=None, rate=None, decimate=None, delay=None, options=None)")]
    fn new(model: &Bound<'_, PyAny>, options: Option<&Bound<'_, PyDict>>) -> PyResult<Accumulator> {
        let model = Model::of(model)?;
        let request: SumsRequest = Call::new("Accumulator", &[], options)?.request()?;
        let inner = &model.get().inner;
        let signal = request.rows.options().signal;
        if signal.order > 0 && signal.cutoff.is_none() {
            return Err(error(
                "Accumulator: [cutoff] is missing: parts of a sum are filtered alike, so it does not follow from a log",
            ));
        }
        let sums = fleet::accumulator(inner, &request).or_error()?;
        Ok(Accumulator { model: model.unbind(), sums: Mutex::new(sums) })
    }

    /// Adds a log, or a list of logs, as for `identify`. Returns itself.
    ///
    /// Raises rist.Error if a log cannot be used, is in the sums already, or does not belong to the model. Nothing of this log
    /// is added then. With anyway=True, a log that does not belong to the model is added.
    #[pyo3(signature = (log, anyway=false))]
    fn update<'py>(slf: Bound<'py, Self>, log: &Bound<'py, PyAny>, anyway: bool) -> PyResult<Bound<'py, Self>> {
        let (this, given) = (slf.get(), logs(log)?);
        let model = &this.model.get().inner;
        for log in given {
            // A log is first added to an empty sum, so that logs that other threads add meanwhile are not lost.
            let mut part = fleet::Accumulator::new(this.sums().settings().clone());
            let part = work(slf.py(), None, |_| {
                let log = log.open(model, &part.settings().options.columns)?;
                fleet::update(model, &mut part, &log, anyway)?;
                Ok(part)
            })?;
            this.sums().merge(&part).or_error()?;
        }
        Ok(slf)
    }

    /// Adds the logs of another accumulator. Returns itself. Raises rist.Error if the settings differ, and says which, or if a
    /// log is in both.
    fn merge<'py>(slf: Bound<'py, Self>, other: &Accumulator) -> PyResult<Bound<'py, Self>> {
        // `other` is copied before `this` is locked, because both may be the same object, and two locks could block each other.
        let (this, other) = (slf.get(), other.copy());
        alone(slf.py(), || this.sums().merge(&other))?.or_error()?;
        Ok(slf)
    }

    /// Notes a log that could not be used. Every estimate from the sums then names this log.
    fn fail(&self, log: String, reason: String) {
        self.sums().fail(log, reason);
    }

    /// The estimate from all logs in the sums.
    fn solve(&self, py: Python<'_>) -> PyResult<Estimate> {
        let sums = self.copy();
        let estimate = work(py, None, |_| Ok(sums.solve()?))?;
        Ok(Estimate::plain(estimate, Some(self.model.clone_ref(py))))
    }

    /// Names of the logs in the sums.
    #[getter]
    fn logs(&self) -> Vec<String> {
        self.sums().logs().iter().map(|log| log.name.clone()).collect()
    }

    /// Number of samples in the sums, after the filter.
    #[getter]
    fn samples(&self) -> usize {
        self.sums().logs().iter().map(|log| log.samples).sum()
    }

    /// Logs that could not be used, each with the reason.
    #[getter]
    fn failed(&self) -> Vec<(String, String)> {
        self.sums().failed().iter().map(|f| (f.name.clone(), f.reason.clone())).collect()
    }

    /// The content of the .tri file of the program.
    fn to_bytes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        Ok(PyBytes::new(py, &self.sums().to_bytes().or_error()?))
    }

    /// Writes the .tri file of the program.
    fn save(&self, path: PathBuf) -> PyResult<()> {
        let bytes = self.sums().to_bytes().or_error()?;
        rist::output::write_file(&path, &bytes, &[&self.model.get().inner.path]).or_error()
    }

    /// Reads a .tri file. Raises rist.Error if the file is not a .tri file, is incomplete, or is of another model.
    #[staticmethod]
    fn read(path: PathBuf, model: &Bound<'_, PyAny>) -> PyResult<Accumulator> {
        let sums = fleet::Accumulator::read(&path).or_error()?;
        Accumulator::of_sums(sums, Model::of(model)?.unbind())
    }

    fn __len__(&self) -> usize {
        self.sums().logs().len()
    }

    fn __repr__(&self) -> String {
        let sums = self.sums();
        let (name, failed) = (&sums.settings().model.name, sums.failed().len());
        format!("<rist.Accumulator {name}: {} logs, {failed} that could not be used>", sums.logs().len())
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, (Bound<'py, PyBytes>, Py<Model>))> {
        Ok((py.import("rist")?.getattr("_accumulator")?, (self.to_bytes(py)?, self.model.clone_ref(py))))
    }
}

impl Accumulator {
    fn of_bytes(path: &Path, bytes: &[u8], model: Py<Model>) -> PyResult<Accumulator> {
        let sums = fleet::Accumulator::from_bytes(&path.display().to_string(), bytes).or_error()?;
        Accumulator::of_sums(sums, model)
    }

    fn of_sums(sums: fleet::Accumulator, model: Py<Model>) -> PyResult<Accumulator> {
        fleet::sums::check_sums(&model.get().inner, &sums).or_error()?;
        Ok(Accumulator { model, sums: Mutex::new(sums) })
    }
}

/// Rebuilds an accumulator from its pickle.
#[pyfunction]
pub fn _accumulator(bytes: &[u8], model: Py<Model>) -> PyResult<Accumulator> {
    Accumulator::of_bytes(Path::new("pickle"), bytes, model)
}

artefact! {
    Comparison,
    fleet::Comparison,
    "What changed between sums: which robots and which parameters, and by how many standard deviations sigma.",
    /// Names of the robots that changed.
    #[getter]
    fn changed(&self) -> Vec<String> {
        self.inner.robots.iter().filter(|r| r.changed).map(|r| r.name.clone()).collect()
    }

    /// Parameters that changed, by the name of the robot: dicts of name -> (difference, sigma), in the unit of the parameter.
    #[getter]
    fn moved<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let all = PyDict::new(py);
        for robot in self.inner.robots.iter().filter(|r| r.changed) {
            let moved = PyDict::new(py);
            for p in robot.parameters.iter().filter(|p| p.moved) {
                moved.set_item(p.name.to_string(), (p.difference, p.sigma))?;
            }
            all.set_item(&robot.name, moved)?;
        }
        Ok(all)
    }
}

impl Comparison {
    /// A comparison has no page.
    fn page(&self, _date: Option<&str>) -> Option<String> {
        None
    }
}

/// Compares the sums of robots with the sums of a reference. robots: sums by name, {"r07": Accumulator, ..}.
///
/// Options:
/// - of: The parameters to compare [default: 'all']
/// - fdr: False discovery rate: the expected share of unchanged robots among the robots reported as changed, and
///   of unchanged parameters among the reported parameters [default: 0.05]
#[pyfunction]
#[pyo3(signature = (reference, robots, **options), text_signature = "(reference, robots, *, of='all', fdr=0.05)")]
pub fn compare(
    py: Python<'_>,
    reference: &Accumulator,
    robots: &Bound<'_, PyDict>,
    options: Option<&Bound<'_, PyDict>>,
) -> PyResult<Comparison> {
    let asked: CompareRequest = Call::new("compare", &[], options)?.request()?;
    let mut named = Vec::new();
    for (name, sums) in robots {
        let sums =
            sums.cast::<Accumulator>().map_err(|_| error("compare: robots is a dict of Accumulators by name"))?;
        named.push((name.extract::<String>()?, sums.get().copy()));
    }
    let reference = reference.copy();
    let inner = work(py, None, |_| {
        let named: Vec<(&str, &fleet::Accumulator)> = named.iter().map(|(name, sums)| (name.as_str(), sums)).collect();
        Ok(fleet::compare(("reference", &reference), &named, asked.of, asked.fdr)?)
    })?;
    Ok(Comparison { inner, model: None })
}
