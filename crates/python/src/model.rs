//! `rist.Model`.

use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};

use numpy::{PyArrayDyn, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};
use rist::ModelOptions;
use rist::evaluation::{Evaluation, ManyStates, Quantity};
use rist::request::spelling::{Reader, flags, spelled};
use rist::request::{GenerateRequest, Request, SourceLanguage};
use rist::source::Language;

use crate::arrays::{Rows, States, array, empty};
use crate::base_parameters::{BaseParameters, standard_names};
use crate::call::{Call, object};
use crate::error::{OrError, error};
use crate::estimate::Estimate;
use crate::html;
use crate::work::alone;

/// States that are evaluated between two looks for signals.
const STATES_PER_PASS: usize = 1 << 14;

/// A robot and what follows from it: base parameters, regressors, torques, source.
///
/// `Model.read(path)` reads a description (.yaml, .urdf, .par) and derives its dynamics. Functions of the state take arrays
/// of shape (N, n), one state per row and one column per coordinate, or (n,) for one state: q in rad (m of a joint that slides),
/// dq in rad/s, ddq in rad/s^2; absent rates are zero. They release the interpreter lock. float64 arrays row by row are not
/// copied.
///
/// >>> model = rist.Model.read("models/panda.yaml")
/// >>> y = model.base_regressor(q, dq, ddq)     # (N, n, p)
/// >>> w = y.reshape(-1, y.shape[-1])           # the observation matrix, (N n, p), without a copy
#[pyclass(frozen, module = "rist")]
pub struct Model {
    pub inner: Arc<rist::Model>,
    /// The description, for pickles.
    pub text: String,
    options: ModelOptions,
    evaluations: [OnceLock<Evaluation>; 6],
}

/// Taken with every evaluation: which arguments and how many dimensions.
type Argument<'a, 'py> = Option<&'a Bound<'py, PyAny>>;

impl Model {
    /// The same description, read as it was for another model.
    pub fn read_as(&self, inner: rist::Model) -> Model {
        let options = inner.description.as_ref().map(ModelOptions::of_description).unwrap_or_default();
        Model { inner: Arc::new(inner), text: self.text.clone(), options, evaluations: Default::default() }
    }

    fn derive(py: Python<'_>, text: String, path: PathBuf, options: ModelOptions) -> PyResult<Model> {
        let derived = || rist::Model::parse(&text, &path, &options);
        let model = alone(py, derived)?.or_error()?;
        let snapped = rist::description::snapping(&model.robot, &text, &path, &options);
        if let Some(sentence) = snapped {
            py.import("warnings")?.call_method1("warn", (spelled(&sentence, Reader::Python),))?;
        }
        Ok(Model { inner: Arc::new(model), text, options, evaluations: Default::default() })
    }

    /// Path, text and options of the description, of which a pickle is made.
    pub fn state<'py>(&self, py: Python<'py>) -> PyResult<(String, String, Bound<'py, PyDict>)> {
        let options = PyDict::new(py);
        for (name, value) in self.options.given() {
            options.set_item(name, object(py, &value)?)?;
        }
        Ok((self.inner.path.display().to_string(), self.text.clone(), options))
    }

    /// The base parameters and their rules, for notebooks.
    pub fn rules_table(&self) -> String {
        let rules = self.inner.parameters.rules();
        let rows = self.inner.parameters.base.iter().zip(rules.base).map(|(b, rule)| vec![b.name.clone(), rule]);
        let title = format!("{}: {} base parameters", self.inner.robot.name, self.inner.parameters.len());
        html::table(&title, &["parameter", "rule"], rows)
    }

    fn evaluation(&self, py: Python<'_>, quantity: Quantity) -> PyResult<&Evaluation> {
        let place = &self.evaluations[quantity as usize];
        if let Some(found) = place.get() {
            return Ok(found);
        }
        let made = alone(py, || Evaluation::new(&self.inner, quantity))?.or_error()?;
        Ok(place.get_or_init(|| made))
    }

    /// Evaluates a quantity at states. The outputs have a dimension for the states, unless a single state was given.
    fn evaluate<'py>(
        &self,
        py: Python<'py>,
        quantity: Quantity,
        [q, dq, ddq]: [Argument<'_, 'py>; 3],
        parameters: Argument<'_, 'py>,
    ) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let evaluation = self.evaluation(py, quantity)?;
        let Some(q) = q else { return Err(error("q is missing")) };
        let needed = [evaluation.needs("dq"), evaluation.needs("ddq")];
        let states = States::new(self.inner.regressor().coordinates(), q, dq, ddq, needed)?;
        let parameters = match evaluation.parameters() {
            Some(_) => self.parameters(parameters)?,
            None => Vec::new(),
        };
        // One state gives an array of one dimension less, and so does a quantity that is a vector.
        let (rows, columns) = evaluation.shape();
        let mut shape = if states.is_one { vec![] } else { vec![states.count] };
        shape.push(rows);
        if matches!(quantity, Quantity::Regressor | Quantity::BaseRegressor | Quantity::InertiaMatrix) {
            shape.push(columns);
        }
        let outputs = empty(py, &shape)?;
        let mut filled = outputs.readwrite();
        let filled = filled.as_slice_mut().map_err(error)?;
        let ([q, dq, ddq], n) = (states.numbers()?, self.inner.robot.n_coordinates());
        // Some states at a time, so that Ctrl-C is heard in between.
        for (first, outputs) in
            (0..states.count).step_by(STATES_PER_PASS).zip(filled.chunks_mut((STATES_PER_PASS * rows * columns).max(1)))
        {
            let end = states.count.min(first + STATES_PER_PASS);
            let cut = |x: &[f64]| -> std::ops::Range<usize> { (first * n).min(x.len())..(end * n).min(x.len()) };
            let some = ManyStates { q: &q[cut(q)], dq: &dq[cut(dq)], ddq: &ddq[cut(ddq)], parameters: &parameters };
            alone(py, || evaluation.fill(&self.inner, &some, outputs))?.or_error()?;
            py.check_signals()?;
        }
        Ok(outputs)
    }

    /// The base parameters: those of an estimate, given ones, or those of the description.
    fn parameters(&self, given: Argument<'_, '_>) -> PyResult<Vec<f64>> {
        let (p, standard) = (self.inner.parameters.len(), self.inner.parameters.standard.len());
        let Some(given) = given.filter(|x| !x.is_none()) else {
            return self.inner.described_parameters().ok_or_else(|| {
                let path = self.inner.path.display();
                error(format_args!(
                    "{path}: it has no inertial parameters; give parameters=, {p} base or {standard} standard ones"
                ))
            });
        };
        if let Ok(estimate) = given.cast::<Estimate>() {
            return self.inner.values(&estimate.get().inner).or_error();
        }
        let rows = Rows::new("parameters", given)?;
        let numbers = rows.numbers()?;
        match rows.shape() {
            [k] if *k == p => Ok(numbers.to_vec()),
            [k] if *k == standard => Ok(self.inner.parameters.values(numbers)),
            _ => Err(error(format_args!(
                "parameters: {p} base parameters or {standard} standard ones are expected, or an Estimate; {} numbers are there",
                numbers.len()
            ))),
        }
    }
}

/// The options of a description out of keyword arguments.
fn options(function: &'static str, given: Option<&Bound<'_, PyDict>>) -> PyResult<ModelOptions> {
    Call::new(function, &[], given)?.request()
}

#[pymethods]
impl Model {
    /// Reads a description (.yaml, .urdf, .par) and derives its dynamics. Angles that are taken for others are a warning.
    /// Raises rist.Error with the place of what cannot be read.
    ///
    /// Options:
    /// - value: Value of a symbol of the description, m or rad: D3=0.45 (symbols of a .par file may have no value)
    /// - mimic: How the mimic joints of a URDF are read: as following the joint they mimic, or as coordinates of
    ///   their own [default: 'constraint']
    /// - angles: How rounded angles are read: as the angles that were meant (1.5707 and 1.5708 as pi/2), or as given
    ///   [default: 'meant']
    /// - rotor_inertia: Which joints have a rotor inertia (IA) among their parameters [default: as the file says; a
    ///   YAML file that does not say: actuated; a URDF, which cannot say: none]
    /// - floating_base: Let the base float: six coordinates come first (base_x, base_y, base_z, base_yaw, base_pitch,
    ///   base_roll), and the base becomes a link with its own parameters [default: False]
    /// - any_size: Derive the model even where that takes more than about 10 s or 1 GiB, which is refused with the
    ///   figures otherwise [default: False]
    #[staticmethod]
    #[pyo3(signature = (path, **options), text_signature = "(path, *, value=None, mimic='constraint', angles='meant', rotor_inertia=None, floating_base=False, any_size=False)")]
    fn read(py: Python<'_>, path: PathBuf, options: Option<&Bound<'_, PyDict>>) -> PyResult<Model> {
        let options = self::options("Model.read", options)?;
        let text = rist::text_of(&path).or_error()?;
        Model::derive(py, text, path, options)
    }

    /// The same of a text; `name` ends in .yaml, .urdf or .par, which tells its format, and stands in messages.
    ///
    /// Options:
    /// - value: Value of a symbol of the description, m or rad: D3=0.45 (symbols of a .par file may have no value)
    /// - mimic: How the mimic joints of a URDF are read: as following the joint they mimic, or as coordinates of
    ///   their own [default: 'constraint']
    /// - angles: How rounded angles are read: as the angles that were meant (1.5707 and 1.5708 as pi/2), or as given
    ///   [default: 'meant']
    /// - rotor_inertia: Which joints have a rotor inertia (IA) among their parameters [default: as the file says; a
    ///   YAML file that does not say: actuated; a URDF, which cannot say: none]
    /// - floating_base: Let the base float: six coordinates come first (base_x, base_y, base_z, base_yaw, base_pitch,
    ///   base_roll), and the base becomes a link with its own parameters [default: False]
    /// - any_size: Derive the model even where that takes more than about 10 s or 1 GiB, which is refused with the
    ///   figures otherwise [default: False]
    #[staticmethod]
    #[pyo3(signature = (text, name="robot.urdf", **options), text_signature = "(text, name='robot.urdf', *, value=None, mimic='constraint', angles='meant', rotor_inertia=None, floating_base=False, any_size=False)")]
    fn parse(py: Python<'_>, text: String, name: &str, options: Option<&Bound<'_, PyDict>>) -> PyResult<Model> {
        Model::derive(py, text, name.into(), self::options("Model.parse", options)?)
    }

    /// The name of the robot.
    #[getter]
    fn name(&self) -> &str {
        &self.inner.robot.name
    }

    /// The file it was read from.
    #[getter]
    fn path(&self) -> PathBuf {
        self.inner.path.clone()
    }

    /// Names of the n coordinates, in the order of the columns of q.
    #[getter]
    fn coordinates(&self) -> Vec<String> {
        self.inner.regressor().coordinates().to_vec()
    }

    /// The p base parameters, with names, rules and matrix.
    #[getter]
    fn base_parameters(slf: &Bound<'_, Self>) -> BaseParameters {
        BaseParameters::of(slf.clone().unbind())
    }

    /// Names of the standard parameters, in the order of the columns of `regressor`: XX XY XZ YY YZ ZZ MX MY MZ M of each
    /// link about its frame (kg m^2, kg m, kg), IA where a joint has a rotor.
    #[getter]
    fn standard_parameters(&self) -> Vec<String> {
        standard_names(&self.inner)
    }

    /// The base parameters of the description's inertial parameters, (p,); None where it has none.
    #[getter]
    fn described_parameters<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArrayDyn<f64>>>> {
        self.inner.described_parameters().map(|x| array(py, &[x.len()], &x)).transpose()
    }

    /// Whether the base regressor is compiled into this package; other robots are evaluated by tape.
    #[getter]
    fn is_compiled(&self) -> bool {
        self.inner.is_compiled()
    }

    /// Y(q, dq, ddq) of the standard parameters, tau = Y X: shape (N, n, p_s), N m (N) per unit of the parameter.
    #[pyo3(signature = (q, dq=None, ddq=None))]
    fn regressor<'py>(
        &self,
        q: &Bound<'py, PyAny>,
        dq: Argument<'_, 'py>,
        ddq: Argument<'_, 'py>,
    ) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        self.evaluate(q.py(), Quantity::Regressor, [Some(q), dq, ddq], None)
    }

    /// Y(q, dq, ddq) of the base parameters, tau = Y X: shape (N, n, p), N m (N) per unit of the parameter.
    ///
    /// reshape(-1, p) makes the observation matrix of it without a copy.
    #[pyo3(signature = (q, dq=None, ddq=None))]
    fn base_regressor<'py>(
        &self,
        q: &Bound<'py, PyAny>,
        dq: Argument<'_, 'py>,
        ddq: Argument<'_, 'py>,
    ) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        self.evaluate(q.py(), Quantity::BaseRegressor, [Some(q), dq, ddq], None)
    }

    /// The joint torques without friction, shape (N, n), N m (N of a joint that slides).
    ///
    /// parameters: p base or p_s standard ones, or an Estimate; without them those of the description.
    #[pyo3(signature = (q, dq=None, ddq=None, parameters=None))]
    fn torque<'py>(
        &self,
        q: &Bound<'py, PyAny>,
        dq: Argument<'_, 'py>,
        ddq: Argument<'_, 'py>,
        parameters: Argument<'_, 'py>,
    ) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        self.evaluate(q.py(), Quantity::Torque, [Some(q), dq, ddq], parameters)
    }

    /// The inertia matrix A(q), shape (N, n, n), kg m^2; parameters as of `torque`.
    #[pyo3(signature = (q, parameters=None))]
    fn inertia_matrix<'py>(
        &self,
        q: &Bound<'py, PyAny>,
        parameters: Argument<'_, 'py>,
    ) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        self.evaluate(q.py(), Quantity::InertiaMatrix, [Some(q), None, None], parameters)
    }

    /// Coriolis, centrifugal and gravity torques, shape (N, n), N m (N); parameters as of `torque`.
    #[pyo3(signature = (q, dq=None, parameters=None))]
    fn bias<'py>(
        &self,
        q: &Bound<'py, PyAny>,
        dq: Argument<'_, 'py>,
        parameters: Argument<'_, 'py>,
    ) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        self.evaluate(q.py(), Quantity::Bias, [Some(q), dq, None], parameters)
    }

    /// Gravity torques, shape (N, n), N m (N); parameters as of `torque`.
    #[pyo3(signature = (q, parameters=None))]
    fn gravity<'py>(
        &self,
        q: &Bound<'py, PyAny>,
        parameters: Argument<'_, 'py>,
    ) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        self.evaluate(q.py(), Quantity::Gravity, [Some(q), None, None], parameters)
    }

    /// Source of the base regressor and of `functions` ("inverse-dynamics", "pose=LINK", ..), as `rist generate` writes it.
    ///
    /// language="rust": the text. language="c": the texts of source and header, the header under the name `header`.
    /// estimate: an Estimate of this model, whose numbers stand in the source as the constants X and F; one whose verdict is
    /// no is refused, unless anyway=True.
    #[pyo3(signature = (language="rust", functions=Vec::new(), header=None, *, estimate=None, anyway=false))]
    fn generate<'py>(
        &self,
        py: Python<'py>,
        language: &str,
        functions: Vec<String>,
        header: Option<String>,
        estimate: Option<&Estimate>,
        anyway: bool,
    ) -> PyResult<Bound<'py, PyAny>> {
        let path = self.inner.path.display();
        // The command that would make the same source, for its banner.
        let values = [("language", language.into()), ("functions", functions.into()), ("anyway", anyway.into())];
        let request: GenerateRequest = rist::request::of_values(values.iter().map(|(name, value)| (*name, value)))
            .map_err(|e| error(format_args!("generate: {e}")))?;
        let made_by = format!("rist generate {path}{}{}", flags(&self.options.given()), flags(&request.given()));
        let values = match estimate {
            None if request.anyway => return Err(error("generate: [anyway=true] is for an [estimate]: give one")),
            None => None,
            Some(estimate) => Some(request.values(&self.inner, Path::new("estimate"), &estimate.inner).or_error()?),
        };
        let language = match request.language {
            SourceLanguage::Rust => Language::Rust,
            SourceLanguage::C => {
                Language::C { header: header.unwrap_or_else(|| format!("{}.h", self.inner.robot.name)) }
            }
        };
        let refused = |e| error(format_args!("{path}: {e}"));
        let (functions, symbols) = (&request.functions, &request.symbols);
        let made = || {
            rist::generate(&self.inner.robot, functions, &language, &made_by, values.as_ref(), symbols, true)
        };
        let source = alone(py, made)?.map_err(refused)?;
        match source.header {
            Some(header) => Ok(PyTuple::new(py, [source.text, header])?.into_any()),
            None => Ok(source.text.into_pyobject(py)?.into_any()),
        }
    }

    fn __repr__(&self) -> String {
        let (name, n) = (&self.inner.robot.name, self.inner.robot.n_coordinates());
        let how = if self.inner.is_compiled() { "compiled" } else { "by tape" };
        let lines = self.inner.parameters.rule_lines().join("\n  ");
        let p = self.inner.parameters.len();
        format!("<rist.Model {name}: {n} coordinates, {p} base parameters, {how}>\n  {lines}")
    }

    fn _repr_html_(&self) -> String {
        self.rules_table()
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, (String, String, Bound<'py, PyDict>))> {
        Ok((py.import("rist")?.getattr("_model")?, self.state(py)?))
    }
}

/// What a pickle of a model calls.
#[pyfunction]
pub fn _model(py: Python<'_>, path: PathBuf, text: String, options: &Bound<'_, PyDict>) -> PyResult<Model> {
    Model::derive(py, text, path, self::options("Model", Some(options))?)
}
