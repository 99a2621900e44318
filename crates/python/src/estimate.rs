//! The class `rist.Estimate`.
//!
//! An estimate has the identified parameters with standard deviations. The object also keeps the model of the fit, the
//! identified bodies (ten inertial parameters per link), and the logs, which are read again for plots.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use arrow_array::{ArrayRef, Float64Array, StringArray};
use numpy::PyArrayDyn;
use pyo3::prelude::*;
use pyo3::types::{PyCapsule, PyDict, PyIterator, PyList, PyTuple};
use rist::fit::samples::Bodies;
use rist::fit::validation::PlotData;
use rist::fit::verdict::Trust;
use rist::page::{Origin, PageRequest};
use rist::request::spelling::Audience;
use rist::{Identified, LinkId, Status};

use crate::arrays::array;
use crate::arrow::stream;
use crate::artefact::{description, hash, place, read_text, save};
use crate::call::object;
use crate::error::{OrError, all_spelled, error, for_python};
use crate::html;
use crate::logs::{LogArgument, logs, open};
use crate::model::Model;
use crate::motions::ExperimentPlan;
use crate::validation::Validation;
use crate::verdict::{Said, Verdict};
use crate::work::work;

/// Identified parameters with their standard deviations, the residuals, and what the data do not determine.
///
/// An estimate is also an Arrow table: pyarrow.table(estimate), polars.DataFrame(estimate). A pickle contains all data of the
/// estimate. estimate.yaml contains no bodies. Therefore write_urdf and write_mjcf need the estimate that `identify` returned,
/// or a pickle of it.
#[pyclass(frozen, module = "rist")]
pub struct Estimate {
    pub inner: rist::Estimate,
    pub model: Option<Py<Model>>,
    pub verdict: Said,
    /// The identified bodies; `None` if physical consistency was not requested.
    pub bodies: Option<Bodies>,
    /// The load in the loaded logs as text, as the program prints it.
    pub load: Option<String>,
    /// Findings of the log check, as sentences.
    pub findings: Vec<String>,
    /// Whether the estimate was read from estimate.yaml. This file contains no bodies.
    pub is_read: bool,
    /// The logs as the user gave them. They are read again for plots of torques.
    pub logs: Option<Py<PyAny>>,
    /// The prediction errors on logs that were not fitted.
    pub validation: Option<rist::Validation>,
    /// Assumptions of a simulation, as sentences.
    pub notes: Vec<String>,
}

/// Largest number of rows with which logs are read again for a notebook, because it requests a page whenever an estimate is
/// shown.
const LARGEST_DRAWN_ROWS: usize = 1 << 20;

/// Bodies in a pickle: link number and ten parameters XX .. M, rotor inertias, and the reason why the bodies must not be used.
type BodyState = (Vec<(usize, [f64; 10])>, Vec<f64>, Option<String>);

impl Estimate {
    /// An estimate from a file or a simulation, without bodies, logs and findings.
    pub fn plain(inner: rist::Estimate, model: Option<Py<Model>>) -> Estimate {
        let verdict = rist::fit::verdict::estimate_verdict(&inner).into();
        let (findings, notes) = (Vec::new(), Vec::new());
        let (bodies, load, logs, validation) = (None, None, None, None);
        Estimate { inner, model, verdict, bodies, load, findings, is_read: false, logs, validation, notes }
    }

    fn numbers<'py>(
        &self,
        py: Python<'py>,
        of: impl Fn(&Identified) -> Option<f64>,
    ) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let numbers: Vec<f64> = self.inner.parameters.iter().map(|p| of(p).unwrap_or(f64::NAN)).collect();
        array(py, &[numbers.len()], &numbers)
    }

    fn the_model(&self) -> PyResult<&Model> {
        self.model
            .as_ref()
            .map(Py::get)
            .ok_or_else(|| error("this estimate was read without its model: Estimate.read(path, model)"))
    }

    /// The logs in the argument `given`; without it, the fitted logs. Fails if these do not exist any more.
    fn logs_or<'py>(&self, given: Option<&Bound<'py, PyAny>>, py: Python<'py>) -> PyResult<Vec<LogArgument>> {
        if let Some(given) = given.or(self.logs.as_ref().map(|logs| logs.bind(py))) {
            return logs(given);
        }
        let paths: Vec<PathBuf> = self.inner.logs.iter().map(PathBuf::from).collect();
        match paths.iter().find(|path| !path.exists()) {
            None if !paths.is_empty() => Ok(paths.into_iter().map(LogArgument::Path).collect()),
            missing => Err(error(format_args!(
                "the log that it was made from is not here{}: give one, log=",
                missing.map_or(String::new(), |path| format!(" ({})", path.display()))
            ))),
        }
    }

    /// The plot data of logs; `None` for an estimate from the experiments of a plan.
    fn plot_data<'py>(&self, py: Python<'py>, log: Option<&Bound<'py, PyAny>>) -> PyResult<Option<PlotData>> {
        let Some(options) = &self.inner.options else { return Ok(None) };
        let (model, given) = (&self.the_model()?.inner, self.logs_or(log, py)?);
        work(py, None, |_| rist::fit::validation::plot_data(model, &self.inner, &open(given, model, &options.columns)?))
    }

    /// The content of a page for this estimate.
    fn page_request<'a>(&'a self, plot_data: Option<&'a PlotData>, date: Option<&'a str>) -> PageRequest<'a> {
        PageRequest {
            model: self.model.as_ref().map(|model| model.get().inner.as_ref()),
            estimate: Some(&self.inner),
            plot_data,
            validation: self.validation.as_ref(),
            verdict: Some(&self.verdict.inner),
            origin: Origin { date, version: env!("CARGO_PKG_VERSION"), command: "rist.Estimate.report", model: None },
            reader: Audience::Python,
            ..PageRequest::default()
        }
    }

    /// The page for a notebook. It has torques if the logs still exist and are not too long. `None` if the page is too large.
    fn framed_page(&self, py: Python<'_>) -> Option<String> {
        let is_drawn = self.inner.rows <= LARGEST_DRAWN_ROWS;
        let plot_data = is_drawn.then(|| self.plot_data(py, None).ok().flatten()).flatten();
        let of = |plot_data: Option<&PlotData>| html::frame(&rist::page::page(&self.page_request(plot_data, None)).0);
        plot_data.as_ref().and_then(|plot_data| of(Some(plot_data))).or_else(|| of(None))
    }

    /// The identified bodies. Fails if the verdict is no, unless `anyway` is set.
    fn bodies(&self, anyway: bool) -> PyResult<Bodies> {
        let Some(bodies) = &self.bodies else {
            return Err(error(match self.is_read {
                true => {
                    "this estimate was read from its file, which holds no bodies: call this on what identify(model, logs, \
                     consistent=True) returned, or on a pickle of that"
                }
                false => {
                    "this estimate has no bodies that can exist: identify(model, logs, consistent=True) makes them"
                }
            }));
        };
        let (trust, reasons) = self.verdict.inner.of_bodies();
        if !anyway && trust == Trust::No {
            let reasons = reasons.join("; ");
            return Err(error(format_args!(
                "not to be trusted: {reasons}; nothing is written for a simulator (anyway=True writes it)"
            )));
        }
        let refusal = if anyway { None } else { bodies.refusal.clone() };
        Ok(Bodies { links: bodies.links.clone(), armatures: bodies.armatures.clone(), refusal })
    }
}

#[pymethods]
impl Estimate {
    /// Reads estimate.yaml. With its model, the estimate can predict other logs. Raises rist.Error if the estimate was made
    /// with another model.
    #[staticmethod]
    #[pyo3(signature = (path, model=None))]
    fn read(path: PathBuf, model: Option<&Bound<'_, PyAny>>) -> PyResult<Estimate> {
        let plain = Estimate::of_text(&read_text(&path)?, &path, None)?;
        let Some(model) = model else { return Ok(plain) };
        let model = Model::for_estimate(model, &plain)?;
        model.get().inner.check_estimate(&path, &plain.inner).or_error()?;
        Ok(Estimate { model: Some(model.unbind()), ..plain })
    }

    /// The model with which the estimate was made. It may have rotor inertias that a URDF cannot contain. None if the estimate
    /// was read without its model.
    #[getter]
    fn model(&self, py: Python<'_>) -> Option<Py<Model>> {
        self.model.as_ref().map(|model| model.clone_ref(py))
    }

    /// How well the estimate predicts the logs of validate=; None without such logs.
    #[getter]
    fn validation(&self, py: Python<'_>) -> Option<Validation> {
        let model = self.model.as_ref().map(|model| model.clone_ref(py));
        self.validation.clone().map(|inner| Validation { inner, model })
    }

    /// Assumptions of a simulation about what the description does not say, as sentences.
    #[getter]
    fn notes(&self) -> Vec<String> {
        all_spelled(&self.notes)
    }

    /// Names of the parameters: base parameters, then friction, couplings and drive gains.
    #[getter]
    fn names(&self) -> Vec<String> {
        self.inner.parameters.iter().map(|p| p.id.to_string()).collect()
    }

    /// SI units, one per parameter.
    #[getter]
    fn units(&self) -> Vec<String> {
        self.inner.parameters.iter().map(|p| p.unit.to_string()).collect()
    }

    /// Values by name; None if the data do not determine the value.
    #[getter]
    fn parameters<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let dict = PyDict::new(py);
        self.inner.parameters.iter().try_for_each(|p| dict.set_item(p.id.to_string(), p.value))?;
        Ok(dict)
    }

    /// Values; NaN if the data do not determine the value.
    #[getter]
    fn values<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        self.numbers(py, |p| p.value)
    }

    /// Standard deviations, in the units of the values. Use these, and not `white_sigma`.
    #[getter]
    fn sigma<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        self.numbers(py, |p| p.sigma)
    }

    /// Standard deviations under the assumption that the model is exact and the noise is white.
    #[getter]
    fn white_sigma<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        self.numbers(py, |p| p.white_sigma)
    }

    /// Status of each value: "identified", "not_significant", "weak", "not_identifiable", or "given" if it was not estimated.
    #[getter]
    fn status(&self) -> Vec<&'static str> {
        let word = |p: &Identified| match p.status {
            Status::Identified => "identified",
            Status::NotSignificant => "not_significant",
            Status::Weak => "weak",
            Status::NotIdentifiable => "not_identifiable",
            Status::Given => "given",
        };
        self.inner.parameters.iter().map(word).collect()
    }

    /// A dict of columns (name, value, sigma, white_sigma, unit, status) for pandas.DataFrame and polars.DataFrame. A value
    /// that the data do not determine is NaN in this dict, and null in the Arrow table.
    #[getter]
    fn table<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let table = PyDict::new(py);
        table.set_item("name", self.names())?;
        table.set_item("value", self.values(py)?)?;
        table.set_item("sigma", self.sigma(py)?)?;
        table.set_item("white_sigma", self.white_sigma(py)?)?;
        table.set_item("unit", self.units())?;
        table.set_item("status", self.status())?;
        Ok(table)
    }

    /// The table as an Arrow stream, for pyarrow.table(estimate) and polars.DataFrame(estimate).
    #[pyo3(signature = (requested_schema=None))]
    fn __arrow_c_stream__<'py>(
        &self,
        py: Python<'py>,
        requested_schema: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyCapsule>> {
        // By the specification of the interface, a requested type may be ignored.
        let _ = requested_schema;
        let texts = |of: Vec<String>| -> ArrayRef { Arc::new(StringArray::from(of)) };
        let numbers = |of: fn(&Identified) -> Option<f64>| -> ArrayRef {
            Arc::new(self.inner.parameters.iter().map(of).collect::<Float64Array>())
        };
        let columns = vec![
            ("name", texts(self.names())),
            ("value", numbers(|p| p.value)),
            ("sigma", numbers(|p| p.sigma)),
            ("white_sigma", numbers(|p| p.white_sigma)),
            ("unit", texts(self.units())),
            ("status", texts(self.status().into_iter().map(String::from).collect())),
        ];
        stream(py, columns)
    }

    /// The covariance of the values, (P, P), for white noise; None unless identify was called with covariance=True.
    #[getter]
    fn covariance<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArrayDyn<f64>>>> {
        let rows = &self.inner.covariance;
        let shape = [rows.len(), rows.len()];
        (!rows.is_empty()).then(|| array(py, &shape, &rows.concat())).transpose()
    }

    /// Sentences on what the data do not determine.
    #[getter]
    fn remarks(&self) -> Vec<String> {
        all_spelled(&self.inner.remarks)
    }

    /// Contradictions between the logs and the description (units, signs, columns), as sentences, the worst first.
    #[getter]
    fn findings(&self) -> Vec<String> {
        all_spelled(&self.findings)
    }

    /// The load on the last link, as the program prints it; None without loaded logs.
    #[getter]
    fn load(&self) -> Option<&str> {
        self.load.as_deref()
    }

    /// Whether to trust the estimate, and why.
    #[getter]
    fn verdict(&self) -> Verdict {
        Verdict { said: self.verdict.clone() }
    }

    /// Relative residual |tau - W X| / |tau| over all joints; None if no torques were fitted.
    #[getter]
    fn total(&self) -> Option<f64> {
        self.inner.total
    }

    /// Relative residual on held-out tenths of the log: each tenth is predicted from the other tenths. None for estimates from
    /// the experiments of a plan.
    #[getter]
    fn cross_validation(&self) -> Option<f64> {
        self.inner.cross_validation
    }

    /// Cut-off of the low-pass, Hz; None if nothing was filtered.
    #[getter]
    fn cutoff(&self) -> Option<f64> {
        self.inner.cutoff
    }

    /// Condition number of the columns of the observation matrix, scaled to unit norm; None if there was no such matrix.
    #[getter]
    fn condition_number(&self) -> Option<f64> {
        self.inner.condition_number
    }

    /// Number of parameters, or combinations of them, that the data determine.
    #[getter]
    fn rank(&self) -> usize {
        self.inner.rank
    }

    /// Number of rows of all joints.
    #[getter]
    fn rows(&self) -> usize {
        self.inner.rows
    }

    /// Residuals of the joints: a dict of columns (coordinate, rms, unit, relative, held_out).
    #[getter]
    fn joints<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let (joints, table) = (&self.inner.joints, PyDict::new(py));
        table.set_item("coordinate", joints.iter().map(|j| j.coordinate.as_str()).collect::<Vec<_>>())?;
        table.set_item("rms", joints.iter().map(|j| j.rms).collect::<Vec<_>>())?;
        table.set_item("unit", joints.iter().map(|j| j.unit.to_string()).collect::<Vec<_>>())?;
        table.set_item("relative", joints.iter().map(|j| j.relative).collect::<Vec<_>>())?;
        table.set_item("held_out", joints.iter().map(|j| j.held_out).collect::<Vec<_>>())?;
        Ok(table)
    }

    /// Measured torques of a log, and torques predicted by the estimate, both filtered as in the fit. Returns a dict: t (N,) in
    /// s, measured and predicted (N, n) in N m (N); for several logs, a list of such dicts. Rows that do not count, at
    /// standstill, are NaN. Without `log`, the logs are used from which the estimate was made.
    #[pyo3(signature = (log=None))]
    fn predict<'py>(&self, py: Python<'py>, log: Option<&Bound<'py, PyAny>>) -> PyResult<Bound<'py, PyAny>> {
        let (model, given) = (&self.the_model()?.inner, self.logs_or(log, py)?);
        let is_one = given.len() == 1;
        let columns = self.inner.options.as_ref().map(|o| o.columns.clone()).unwrap_or_default();
        let series = work(py, None, |_| {
            rist::fit::validation::predicted_torques(model, &self.inner, &open(given, model, &columns)?)
        })?;
        let n = model.robot.n_coordinates();
        let mut found = Vec::new();
        for one in &series {
            let dict = PyDict::new(py);
            dict.set_item("log", &one.name)?;
            dict.set_item("t", array(py, &[one.t.len()], &one.t)?)?;
            dict.set_item("measured", array(py, &[one.t.len(), n], &one.measured)?)?;
            dict.set_item("predicted", array(py, &[one.t.len(), n], &one.predicted)?)?;
            found.push(dict);
        }
        match (is_one, found.pop()) {
            (true, Some(one)) => Ok(one.into_any()),
            (_, last) => {
                found.extend(last);
                Ok(PyList::new(py, found)?.into_any())
            }
        }
    }

    /// The text of estimate.yaml, byte for byte the same as the file of the program.
    fn to_yaml(&self) -> PyResult<String> {
        self.inner.to_yaml().or_error()
    }

    /// Writes estimate.yaml.
    fn save(&self, path: PathBuf) -> PyResult<()> {
        let mut inputs = description(self.model.as_ref());
        inputs.extend(self.inner.logs.iter().map(Path::new));
        save(&path, &self.to_yaml()?, &inputs)
    }

    /// Writes one self-contained HTML page: the verdict, torques and residuals, the parameters with their rules and meanings,
    /// and the plan and the validation if they are given. The torques are those of `log`, or of the logs from which the
    /// estimate was made, if these logs still exist.
    #[pyo3(signature = (path, plan=None, validation=None, date=None, log=None))]
    fn report<'py>(
        &self,
        py: Python<'py>,
        path: PathBuf,
        plan: Option<&ExperimentPlan>,
        validation: Option<&Validation>,
        date: Option<&str>,
        log: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<()> {
        let plot_data = match self.plot_data(py, log) {
            Err(e) if log.is_some() => return Err(e),
            plot_data => plot_data.ok().flatten(),
        };
        let request = self.page_request(plot_data.as_ref(), date);
        let request = PageRequest {
            plan: plan.map(|p| &p.inner),
            validation: validation.map(|v| &v.inner).or(request.validation),
            ..request
        };
        save(&path, &rist::page::page(&request).0, &[])
    }

    /// Draws measured and identified torques of a log joint by joint, and the residual. Without `log`, the logs are drawn from
    /// which the estimate was made. For an estimate from experiments, its parameters are drawn. Returns axes of matplotlib;
    /// without matplotlib, a rist.Picture of the page.
    #[pyo3(signature = (log=None))]
    fn plot<'py>(slf: &Bound<'py, Self>, log: Option<&Bound<'py, PyAny>>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("rist._plot")?.call_method1("estimate", (slf, log))
    }

    /// The charts of the HTML page of this estimate: the name and the SVG text of each chart.
    #[pyo3(signature = (log=None))]
    fn _pictures<'py>(&self, py: Python<'py>, log: Option<&Bound<'py, PyAny>>) -> PyResult<Vec<(String, String)>> {
        let plot_data = self.plot_data(py, log)?;
        Ok(rist::page::page(&self.page_request(plot_data.as_ref(), None)).1)
    }

    /// Writes the URDF of the model with the identified bodies, joint damping and friction; needs consistent=True.
    ///
    /// Returns sentences on what a URDF cannot contain. Raises rist.Error if the verdict is no, unless anyway=True.
    #[pyo3(signature = (path, anyway=false))]
    fn write_urdf(&self, path: PathBuf, anyway: bool) -> PyResult<Vec<String>> {
        let (bodies, model) = (self.bodies(anyway)?, self.the_model()?);
        let text = rist::describe::description::without_macros(&model.text, &model.inner.path, &model.options);
        let written = rist::write_urdf(&model.inner, &text.or_error()?, &bodies, &self.inner).or_error()?;
        save(&path, &written.text, &[&model.inner.path])?;
        Ok(written.notes)
    }

    /// Writes a MuJoCo model with the identified inertials, damping, friction loss and armature; needs consistent=True. If the
    /// model was read from an MJCF, the rest of that file is kept.
    #[pyo3(signature = (path, anyway=false))]
    fn write_mjcf(&self, path: PathBuf, anyway: bool) -> PyResult<()> {
        let (bodies, model) = (self.bodies(anyway)?, self.the_model()?);
        let own = rist::own_mjcf(&model.inner, &model.text, &model.options).or_error()?;
        let path_of_own = model.inner.path.display().to_string();
        let into = own.as_ref().map(|text| (path_of_own.as_str(), text.as_str()));
        let mjcf = rist::write_mjcf(&model.inner, &bodies, &self.inner, into).or_error()?;
        save(&path, &mjcf.text, &[&model.inner.path])
    }

    fn __repr__(&self) -> String {
        for_python(&format!("{}\n{}", self.inner, self.verdict.text))
    }

    fn _repr_html_(&self, py: Python<'_>) -> String {
        if let Some(page) = self.framed_page(py) {
            return page;
        }
        let row = |(p, status): (&Identified, &str)| {
            let number = |x: Option<f64>| x.map_or(String::new(), |x| format!("{x:.5}"));
            vec![
                p.id.to_string(),
                number(p.value),
                number(p.sigma),
                number(p.white_sigma),
                p.unit.to_string(),
                status.into(),
            ]
        };
        let rows = self.inner.parameters.iter().zip(self.status()).map(row);
        let head = ["parameter", "value", "sigma", "white", "unit", "status"];
        let title = format!("{}: {}", self.inner.model, self.inner.method);
        let verdict = for_python(&self.verdict.text);
        html::table(&title, &head, rows) + &html::text(&verdict)
    }

    /// A value by its name, estimate["ZZR1"], or by its index, as in a list. None if the data do not determine the value. If
    /// the name is unknown, KeyError proposes a similar name.
    fn __getitem__(&self, name: &Bound<'_, PyAny>) -> PyResult<Option<f64>> {
        Ok(self.inner.parameters[place(name, &self.names())?].value)
    }

    fn __contains__(&self, name: &str) -> bool {
        self.inner.parameters.iter().any(|p| p.id.to_string() == name)
    }

    fn __len__(&self) -> usize {
        self.inner.parameters.len()
    }

    /// The names.
    fn __iter__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyIterator>> {
        PyList::new(py, self.names())?.try_iter()
    }

    /// The content of estimate.yaml, as dicts, lists, texts and numbers.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        object(py, &serde_json::to_value(&self.inner).map_err(error)?)
    }

    /// Two estimates are equal if their files are the same.
    fn __eq__(&self, other: &Bound<'_, Estimate>) -> PyResult<bool> {
        Ok(self.to_yaml()? == other.get().to_yaml()?)
    }

    fn __hash__(&self) -> PyResult<u64> {
        Ok(hash(&self.to_yaml()?))
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyTuple>)> {
        let bodies: Option<BodyState> = self.bodies.as_ref().map(|bodies| {
            let links = bodies.links.iter().map(|(link, body)| (link.0, *body)).collect();
            (links, bodies.armatures.clone(), bodies.refusal.clone())
        });
        let model = self.model.as_ref().map(|m| m.clone_ref(py));
        let validation = self.validation.as_ref().map(|v| v.to_yaml().or_error()).transpose()?;
        let more = (self.findings.clone(), self.load.clone(), bodies, self.is_read, validation, self.notes.clone());
        let state = (self.to_yaml()?, model, self.verdict(), more);
        Ok((py.import("rist")?.getattr("_estimate")?, state.into_pyobject(py)?))
    }
}

impl Estimate {
    fn of_text(text: &str, path: &Path, model: Option<Py<Model>>) -> PyResult<Estimate> {
        let inner = rist::Estimate::from_yaml(&path.display().to_string(), text).or_error()?;
        if let Some(model) = &model {
            Arc::clone(&model.get().inner).check_estimate(path, &inner).or_error()?;
        }
        Ok(Estimate { is_read: true, ..Estimate::plain(inner, model) })
    }
}

/// Content of the pickle of an estimate, in addition to its text: findings, load, bodies, whether it was read from a file,
/// validation, notes.
type More = (Vec<String>, Option<String>, Option<BodyState>, bool, Option<String>, Vec<String>);

/// Rebuilds an estimate from its pickle.
#[pyfunction]
pub fn _estimate(text: &str, model: Option<Py<Model>>, verdict: &Verdict, more: More) -> PyResult<Estimate> {
    let (findings, load, bodies, is_read, validation, notes) = more;
    let validation = validation.map(|text| rist::Validation::from_yaml("pickle", &text).or_error()).transpose()?;
    let bodies = bodies.map(|(links, armatures, refusal)| Bodies {
        links: links.into_iter().map(|(link, body)| (LinkId(link), body)).collect(),
        armatures,
        refusal,
    });
    let read = Estimate::of_text(text, Path::new("pickle"), model)?;
    Ok(Estimate { verdict: verdict.said.clone(), findings, load, bodies, is_read, validation, notes, ..read })
}
