//! The class `rist.Model`.
//!
//! A model is a robot description with derived dynamics. Functions that were derived once are kept. A pickle contains the text
//! of the description and the reading options, and derives the model again.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use numpy::PyArrayDyn;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};
use rist::ModelOptions;
use rist::describe::source::Language;
use rist::request::spelling::flags;
use rist::request::{GenerateRequest, InspectRequest, Request, SourceLanguage};

use crate::arrays::array;
use crate::artefact::{hash, save};
use crate::base_parameters::{BaseParameters, standard_names};
use crate::call::{Call, object};
use crate::error::{OrError, error, for_python, renamed};
use crate::estimate::Estimate;
use crate::evaluate::{Array, Evaluations, OptionalArgument, by_keyword, evaluate, of_link};
use crate::html;
use crate::work::alone;

/// A robot and the functions that follow from its description: base parameters, regressors, torques, source code.
///
/// `Model(path)` reads a description (.yaml, .urdf, .xacro, .xml of MuJoCo, .par) and derives its dynamics, in the same way as
/// `Model.read`. Functions of the state take arrays of shape (N, n), one state per row and one column per coordinate, or (n,)
/// for one state: q in rad (m for a prismatic joint), dq in rad/s, ddq in rad/s^2. If dq or ddq is missing, it is zero. These
/// functions release the interpreter lock. They do not copy float64 arrays in row-major order.
///
/// >>> model = rist.Model("models/panda.yaml")
/// >>> y = model.base_regressor(q, dq, ddq)     # (N, n, p)
/// >>> w = y.reshape(-1, y.shape[-1])           # the observation matrix, (N n, p), without a copy
///
/// Options:
/// - value: Value of a symbol of the description, m or rad: D3=0.45. A .par file may have symbols without a value
/// - arg: Value of an argument of a xacro, which the file uses as `$(arg NAME)` [default: as in the file]
/// - package: Folder of a package, for includes of a xacro (`$(find NAME)`) or meshes and parts of an MJCF.
///   Without this option, a xacro finds packages with a package.xml in the folders above the file
/// - root: The robot to read, if a file has several: a body of the world of an MJCF, or a model of an SDF
///   [default: all that is in the file]
/// - mimic: How mimic joints of a URDF are read. constraint: they follow the joint that they mimic; independent:
///   they are coordinates of their own [default: 'constraint']
/// - angles: How rounded angles are read. meant: as the exact angles (1.5707 and 1.5708 as pi/2); as-given: as
///   the numbers in the file [default: 'meant']
/// - rotor_inertia: Joints that have a rotor inertia (IA) among their parameters [default: as in the file; if the
///   file says nothing: actuated for YAML, none for URDF]
/// - lock: Joints locked at a position, rad or m, such as a gripper that is not in the log: finger=0.02. Without
///   this option, no joint is locked
/// - base: Mount of the base, rad: roll, pitch and yaw of the base frame, in a frame in which gravity is as in
///   the file. 3.1416,0,0 is a robot on a ceiling [default: as in the file]
/// - floating_base: Let the base float: six coordinates come first (base_x, base_y, base_z, base_yaw, base_pitch,
///   base_roll), and the base becomes a link with its own parameters [default: False]
/// - any_size: Derive the model even if this takes more than about 10 s or 1 GiB. Otherwise such a model is
///   refused, with an estimate of time and memory [default: False]
#[pyclass(frozen, module = "rist")]
pub struct Model {
    pub inner: Arc<rist::Model>,
    /// The text of the description. Pickles contain it.
    pub text: String,
    pub options: ModelOptions,
    /// Functions that were derived so far, by name.
    pub evaluations: Evaluations,
}

impl Model {
    /// A Python model with the description of `self` and the reading options of `inner`.
    pub fn read_as(&self, inner: rist::Model) -> Model {
        let options = inner.description.as_ref().map(ModelOptions::of_description).unwrap_or_default();
        Model { inner: Arc::new(inner), text: self.text.clone(), options, evaluations: Default::default() }
    }

    /// Takes a model, or the path of a description, which is read with default options.
    pub fn of<'py>(given: &Bound<'py, PyAny>) -> PyResult<Bound<'py, Model>> {
        Model::read_with(given, ModelOptions::default())
    }

    /// The model with which an estimate predicts torques. If the description is the same, it is the estimate's own model,
    /// because that may have rotor inertias that a URDF cannot contain.
    pub fn for_estimate<'py>(given: &Bound<'py, PyAny>, estimate: &Estimate) -> PyResult<Bound<'py, Model>> {
        let py = given.py();
        let described = estimate.inner.description.clone().unwrap_or_default();
        let model = Model::read_with(given, ModelOptions::of_description(&described))?;
        if let Some(used) = estimate.model.as_ref().filter(|used| used.get().text == model.get().text) {
            return Ok(used.bind(py).clone());
        }
        // Options of the given model replace options of the estimate, one by one.
        let Model { inner, text, options, .. } = model.get();
        let over = options.over(&described).or_error()?;
        if over.description() == inner.description {
            return Ok(model);
        }
        Bound::new(py, Model::derive(py, text.clone(), inner.path.clone(), over)?)
    }

    /// Takes a model, or the path of a description, which is read with `options`.
    fn read_with<'py>(given: &Bound<'py, PyAny>, options: ModelOptions) -> PyResult<Bound<'py, Model>> {
        if let Ok(model) = given.cast::<Model>() {
            return Ok(model.clone());
        }
        let path: PathBuf = given.extract().map_err(|_| {
            let found = given.get_type().qualname().map_or(String::new(), |name| format!(", not {name}"));
            error(format_args!(
                "a model is a rist.Model or the path of its description ({}){found}",
                rist::READ_EXTENSIONS
            ))
        })?;
        let text = rist::text_of(&path).or_error()?;
        Bound::new(given.py(), Model::derive(given.py(), text, path, options)?)
    }

    /// The model read again with the option `rotor_inertia`, which selects the joints with a rotor inertia.
    pub fn with_rotors<'py>(this: &Bound<'py, Model>, given: &Bound<'py, PyAny>) -> PyResult<Bound<'py, Model>> {
        let (py, model) = (this.py(), this.get());
        let asked = PyDict::new(py);
        asked.set_item("rotor_inertia", given)?;
        let rotor_inertia = options("identify", Some(&asked))?.rotor_inertia;
        if model.options.rotor_inertia == rotor_inertia {
            return Ok(this.clone());
        }
        let options = ModelOptions { rotor_inertia, ..model.options.clone() };
        Bound::new(py, Model::derive(py, model.text.clone(), model.inner.path.clone(), options)?)
    }

    /// The HTML page of `rist inspect`.
    fn page(&self) -> Result<String, rist::Error> {
        let path = &self.inner.path;
        let robot = rist::parse_robot(&self.text, path, &self.options)?;
        Ok(rist::inspect(robot, path, &self.options, &InspectRequest::default())?.html())
    }

    fn derive(py: Python<'_>, text: String, path: PathBuf, options: ModelOptions) -> PyResult<Model> {
        let derived = || rist::Model::parse(&text, &path, &options);
        let model = alone(py, derived)?.or_error()?;
        let snapped = rist::describe::description::snapping(&model.robot, &text, &path, &options);
        if let Some(sentence) = snapped {
            py.import("warnings")?.call_method1("warn", (for_python(&sentence),))?;
        }
        Ok(Model { inner: Arc::new(model), text, options, evaluations: Default::default() })
    }

    /// Content of the pickle of a model: path, text and options of its description.
    pub fn state<'py>(&self, py: Python<'py>) -> PyResult<(String, String, Bound<'py, PyDict>)> {
        let options = PyDict::new(py);
        for (name, value) in self.options.given() {
            options.set_item(name, object(py, &value)?)?;
        }
        Ok((self.inner.path.display().to_string(), self.text.clone(), options))
    }

    /// The base parameters and their rules as an HTML table for notebooks.
    pub fn rules_table(&self) -> String {
        let rules = self.inner.parameters.rules();
        let rows = self.inner.parameters.base.iter().zip(rules.base).map(|(b, rule)| vec![b.name.clone(), rule]);
        let title = format!("{}: {} base parameters", self.inner.robot.name, self.inner.parameters.len());
        html::table(&title, &["parameter", "rule"], rows)
    }
}

/// Options for reading a description, from keyword arguments.
fn options(function: &'static str, given: Option<&Bound<'_, PyDict>>) -> PyResult<ModelOptions> {
    Call::new(function, &[], given)?.request()
}

#[pymethods]
impl Model {
    #[new]
    #[pyo3(signature = (path, **options), text_signature = "(path, *, value=None, arg=None, package=None, root=None, mimic='constraint', angles='meant', rotor_inertia=None, lock=None, base=None, floating_base=False, any_size=False)")]
    fn new(py: Python<'_>, path: PathBuf, options: Option<&Bound<'_, PyDict>>) -> PyResult<Model> {
        Model::read(py, path, options)
    }

    /// Reads a description (.yaml, .urdf, .xacro, .xml of MuJoCo, .par) and derives its dynamics. A warning names the angles of
    /// the file that are read as other angles (see angles). Raises rist.Error with the place that cannot be read.
    ///
    /// Options:
    /// - value: Value of a symbol of the description, m or rad: D3=0.45. A .par file may have symbols without a value
    /// - arg: Value of an argument of a xacro, which the file uses as `$(arg NAME)` [default: as in the file]
    /// - package: Folder of a package, for includes of a xacro (`$(find NAME)`) or meshes and parts of an MJCF.
    ///   Without this option, a xacro finds packages with a package.xml in the folders above the file
    /// - root: The robot to read, if a file has several: a body of the world of an MJCF, or a model of an SDF
    ///   [default: all that is in the file]
    /// - mimic: How mimic joints of a URDF are read. constraint: they follow the joint that they mimic; independent:
    ///   they are coordinates of their own [default: 'constraint']
    /// - angles: How rounded angles are read. meant: as the exact angles (1.5707 and 1.5708 as pi/2); as-given: as
    ///   the numbers in the file [default: 'meant']
    /// - rotor_inertia: Joints that have a rotor inertia (IA) among their parameters [default: as in the file; if the
    ///   file says nothing: actuated for YAML, none for URDF]
    /// - lock: Joints locked at a position, rad or m, such as a gripper that is not in the log: finger=0.02. Without
    ///   this option, no joint is locked
    /// - base: Mount of the base, rad: roll, pitch and yaw of the base frame, in a frame in which gravity is as in
    ///   the file. 3.1416,0,0 is a robot on a ceiling [default: as in the file]
    /// - floating_base: Let the base float: six coordinates come first (base_x, base_y, base_z, base_yaw, base_pitch,
    ///   base_roll), and the base becomes a link with its own parameters [default: False]
    /// - any_size: Derive the model even if this takes more than about 10 s or 1 GiB. Otherwise such a model is
    ///   refused, with an estimate of time and memory [default: False]
    #[staticmethod]
    #[pyo3(signature = (path, **options), text_signature = "(path, *, value=None, arg=None, package=None, root=None, mimic='constraint', angles='meant', rotor_inertia=None, lock=None, base=None, floating_base=False, any_size=False)")]
    fn read(py: Python<'_>, path: PathBuf, options: Option<&Bound<'_, PyDict>>) -> PyResult<Model> {
        let options = self::options("Model", options)?;
        let text = rist::text_of(&path).or_error()?;
        Model::derive(py, text, path, options)
    }

    /// Reads a description from a text. `name` is used in messages, and its ending (.yaml, .urdf or .par) gives the format.
    ///
    /// Options:
    /// - value: Value of a symbol of the description, m or rad: D3=0.45. A .par file may have symbols without a value
    /// - arg: Value of an argument of a xacro, which the file uses as `$(arg NAME)` [default: as in the file]
    /// - package: Folder of a package, for includes of a xacro (`$(find NAME)`) or meshes and parts of an MJCF.
    ///   Without this option, a xacro finds packages with a package.xml in the folders above the file
    /// - root: The robot to read, if a file has several: a body of the world of an MJCF, or a model of an SDF
    ///   [default: all that is in the file]
    /// - mimic: How mimic joints of a URDF are read. constraint: they follow the joint that they mimic; independent:
    ///   they are coordinates of their own [default: 'constraint']
    /// - angles: How rounded angles are read. meant: as the exact angles (1.5707 and 1.5708 as pi/2); as-given: as
    ///   the numbers in the file [default: 'meant']
    /// - rotor_inertia: Joints that have a rotor inertia (IA) among their parameters [default: as in the file; if the
    ///   file says nothing: actuated for YAML, none for URDF]
    /// - lock: Joints locked at a position, rad or m, such as a gripper that is not in the log: finger=0.02. Without
    ///   this option, no joint is locked
    /// - base: Mount of the base, rad: roll, pitch and yaw of the base frame, in a frame in which gravity is as in
    ///   the file. 3.1416,0,0 is a robot on a ceiling [default: as in the file]
    /// - floating_base: Let the base float: six coordinates come first (base_x, base_y, base_z, base_yaw, base_pitch,
    ///   base_roll), and the base becomes a link with its own parameters [default: False]
    /// - any_size: Derive the model even if this takes more than about 10 s or 1 GiB. Otherwise such a model is
    ///   refused, with an estimate of time and memory [default: False]
    #[staticmethod]
    #[pyo3(signature = (text, name="robot.urdf", **options), text_signature = "(text, name='robot.urdf', *, value=None, arg=None, package=None, root=None, mimic='constraint', angles='meant', rotor_inertia=None, lock=None, base=None, floating_base=False, any_size=False)")]
    fn parse(py: Python<'_>, text: String, name: &str, options: Option<&Bound<'_, PyDict>>) -> PyResult<Model> {
        Model::derive(py, text, name.into(), self::options("Model.parse", options)?)
    }

    /// The name of the robot.
    #[getter]
    fn name(&self) -> &str {
        &self.inner.robot.name
    }

    /// The file from which the description was read.
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

    /// Names of the standard parameters, in the order of the columns of `regressor`: XX XY XZ YY YZ ZZ MX MY MZ M of each link
    /// about the origin of its frame (kg m^2, kg m, kg), and IA of each joint with a rotor inertia.
    #[getter]
    fn standard_parameters(&self) -> Vec<String> {
        standard_names(&self.inner)
    }

    /// Nominal base parameters, (p,), from the inertial parameters of the description; None if the description has none.
    #[getter]
    fn nominal_parameters<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArrayDyn<f64>>>> {
        self.inner.nominal_parameters().map(|x| array(py, &[x.len()], &x)).transpose()
    }

    /// The former name of `nominal_parameters`.
    #[getter]
    fn described_parameters<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArrayDyn<f64>>>> {
        renamed(py, "described_parameters is called nominal_parameters")?;
        self.nominal_parameters(py)
    }

    /// Whether the base regressor is compiled into this package. Otherwise it is evaluated from a list of operations (a tape).
    #[getter]
    fn is_compiled(&self) -> bool {
        self.inner.is_compiled()
    }

    /// Y(q, dq, ddq) of the standard parameters, tau = Y X: shape (N, n, p_s), N m (N) per unit of the parameter.
    #[pyo3(signature = (q, dq=None, ddq=None))]
    fn regressor(&self, q: &Array, dq: OptionalArgument, ddq: OptionalArgument) -> PyResult<Py<PyAny>> {
        self.one("regressor", [Some(q), dq, ddq], None, &[])
    }

    /// Y(q, dq, ddq) of the base parameters, tau = Y X: shape (N, n, p), N m (N) per unit of the parameter.
    ///
    /// reshape(-1, p) gives the observation matrix without a copy.
    #[pyo3(signature = (q, dq=None, ddq=None))]
    fn base_regressor(&self, q: &Array, dq: OptionalArgument, ddq: OptionalArgument) -> PyResult<Py<PyAny>> {
        self.one("base-regressor", [Some(q), dq, ddq], None, &[])
    }

    /// The joint torques without friction, shape (N, n), N m (N for a prismatic joint).
    ///
    /// parameters: p base parameters, p_s standard parameters, or an Estimate. Without this argument, the parameters of the
    /// description are used.
    #[pyo3(signature = (q, dq=None, ddq=None, parameters=None))]
    fn torque(
        &self,
        q: &Array,
        dq: OptionalArgument,
        ddq: OptionalArgument,
        parameters: OptionalArgument,
    ) -> PyResult<Py<PyAny>> {
        self.one("inverse-dynamics", [Some(q), dq, ddq], parameters, &[])
    }

    /// The inertia matrix A(q), shape (N, n, n), kg m^2; parameters as for `torque`.
    #[pyo3(signature = (q, parameters=None))]
    fn inertia_matrix(&self, q: &Array, parameters: OptionalArgument) -> PyResult<Py<PyAny>> {
        self.one("inertia-matrix", [Some(q), None, None], parameters, &[])
    }

    /// Coriolis, centrifugal and gravity torques, shape (N, n), N m (N); parameters as for `torque`.
    #[pyo3(signature = (q, dq=None, parameters=None))]
    fn bias(&self, q: &Array, dq: OptionalArgument, parameters: OptionalArgument) -> PyResult<Py<PyAny>> {
        self.one("bias", [Some(q), dq, None], parameters, &[])
    }

    /// Gravity torques, shape (N, n), N m (N); parameters as for `torque`.
    #[pyo3(signature = (q, parameters=None))]
    fn gravity(&self, q: &Array, parameters: OptionalArgument) -> PyResult<Py<PyAny>> {
        self.one("gravity", [Some(q), None, None], parameters, &[])
    }

    /// Kinetic and potential energy, shape (N, 2), J; parameters as for `torque`. With base parameters, the potential energy is
    /// determined only up to a constant.
    #[pyo3(signature = (q, dq=None, parameters=None))]
    fn energy(&self, q: &Array, dq: OptionalArgument, parameters: OptionalArgument) -> PyResult<Py<PyAny>> {
        self.one("energies", [Some(q), dq, None], parameters, &[])
    }

    /// The accelerations that follow from the torques tau, without friction, shape (N, n), rad/s^2 (m/s^2); parameters as for
    /// `torque`.
    #[pyo3(signature = (q, dq, tau, parameters=None))]
    fn forward_dynamics(
        &self,
        q: &Array,
        dq: OptionalArgument,
        tau: &Array,
        parameters: OptionalArgument,
    ) -> PyResult<Py<PyAny>> {
        self.one("forward-dynamics", [Some(q), dq, None], parameters, &[("tau", tau)])
    }

    /// Derivatives of the torques with respect to q and to dq, each (N, n, n), N m per rad and N m per rad/s. The derivative
    /// with respect to ddq is the inertia matrix.
    #[pyo3(signature = (q, dq=None, ddq=None, parameters=None))]
    fn torque_derivatives(
        &self,
        q: &Array,
        dq: OptionalArgument,
        ddq: OptionalArgument,
        parameters: OptionalArgument,
    ) -> PyResult<Py<PyTuple>> {
        self.several("inverse-dynamics-derivatives", [Some(q), dq, ddq], parameters, &[])
    }

    /// Derivatives of the accelerations with respect to q, dq and tau, each (N, n, n).
    #[pyo3(signature = (q, dq, tau, parameters=None))]
    fn forward_dynamics_derivatives(
        &self,
        q: &Array,
        dq: OptionalArgument,
        tau: &Array,
        parameters: OptionalArgument,
    ) -> PyResult<Py<PyTuple>> {
        self.several("forward-dynamics-derivatives", [Some(q), dq, None], parameters, &[("tau", tau)])
    }

    /// Orientation and position of a link, (N, 3, 4), in the base frame, or in the frame of another link.
    #[pyo3(signature = (link, q, frame=None))]
    fn pose(&self, link: &str, q: &Array, frame: Option<&str>) -> PyResult<Py<PyAny>> {
        self.one(&of_link("pose", link, frame), [Some(q), None, None], None, &[])
    }

    /// Jacobian of a link, (N, 6, n): the velocity of its origin, then its angular velocity. The axes are the axes of the link
    /// itself, or with `frame` the axes of another link or of "base".
    #[pyo3(signature = (link, q, frame=None))]
    fn jacobian(&self, link: &str, q: &Array, frame: Option<&str>) -> PyResult<Py<PyAny>> {
        self.one(&of_link("jacobian", link, frame), [Some(q), None, None], None, &[])
    }

    /// Any function of `rist generate` by its name ("coriolis-matrix", "velocity=LINK", "inverse-geometry=LINK", ..). Returns
    /// the output, or a dict of outputs by name if there are several. Inputs other than q, dq, ddq and parameters are given by
    /// keyword, one row per state: tau=, wrench=, point=, t=, dq_r=, ddq_r=.
    #[pyo3(signature = (function, q=None, dq=None, ddq=None, parameters=None, **others))]
    fn evaluate<'py>(
        &self,
        py: Python<'py>,
        function: &str,
        q: OptionalArgument<'_, 'py>,
        dq: OptionalArgument<'_, 'py>,
        ddq: OptionalArgument<'_, 'py>,
        parameters: OptionalArgument<'_, 'py>,
        others: Option<&Bound<'py, PyDict>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let others = by_keyword(others)?;
        let others: Vec<(&str, &Bound<'py, PyAny>)> = others.iter().map(|(name, x)| (name.as_str(), x)).collect();
        let mut found = evaluate(py, self, function, [q, dq, ddq], parameters, &others)?;
        match found.len() {
            1 => Ok(found.remove(0).1),
            _ => {
                let by_name = PyDict::new(py);
                found.into_iter().try_for_each(|(name, x)| by_name.set_item(name, x))?;
                Ok(by_name.into_any())
            }
        }
    }

    /// Source of the base regressor and of `functions` ("inverse-dynamics", "pose=LINK", ..), as `rist generate` writes it.
    ///
    /// language="rust": returns the text. language="c": returns the texts of the source and of the header; `header` is the name
    /// of the header.
    /// estimate: an Estimate of this model. Its numbers are written into the source as the constants X and F. An estimate whose
    /// verdict is no is refused, unless anyway=True.
    /// symbols: lengths, angles and components of gravity that are not fixed, but given in an argument `symbols` of all
    /// functions.
    #[pyo3(signature = (language="rust", functions=Vec::new(), header=None, *, estimate=None, anyway=false, symbols=Vec::new()))]
    fn generate<'py>(
        &self,
        py: Python<'py>,
        language: &str,
        functions: Vec<String>,
        header: Option<String>,
        estimate: Option<&Estimate>,
        anyway: bool,
        symbols: Vec<String>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let path = self.inner.path.display();
        // Options of the equivalent command, which the head of the source shows.
        let values = [
            ("language", language.into()),
            ("functions", functions.into()),
            ("anyway", anyway.into()),
            ("symbols", symbols.into()),
        ];
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
        let made = || rist::generate(&self.inner.robot, functions, &language, &made_by, values.as_ref(), symbols, true);
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

    fn _repr_html_(&self, py: Python<'_>) -> String {
        let page = alone(py, || self.page()).ok().and_then(Result::ok);
        page.and_then(|page| html::frame(&page)).unwrap_or_else(|| self.rules_table())
    }

    /// Writes the HTML page of `rist inspect`: the robot with its frames, and the base parameters with their meanings and
    /// rules.
    fn report(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        save(&path, &alone(py, || self.page())?.or_error()?, &[&self.inner.path])
    }

    /// The output of `rist inspect --format json`, as dicts, lists, texts and numbers.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let path = &self.inner.path;
        let found = || {
            let robot = rist::parse_robot(&self.text, path, &self.options)?;
            Ok(rist::inspect(robot, path, &self.options, &InspectRequest::default())?.to_json())
        };
        object(py, &alone(py, found)?.map_err(|e: rist::Error| error(e))?)
    }

    /// Two models are equal if their descriptions are the same text, read with the same options.
    fn __eq__(&self, other: &Bound<'_, Model>) -> bool {
        let other = other.get();
        self.text == other.text && self.options.given() == other.options.given()
    }

    fn __hash__(&self) -> u64 {
        hash(&self.text)
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, (String, String, Bound<'py, PyDict>))> {
        Ok((py.import("rist")?.getattr("_model")?, self.state(py)?))
    }
}

/// Rebuilds a model from its pickle.
#[pyfunction]
pub fn _model(py: Python<'_>, path: PathBuf, text: String, options: &Bound<'_, PyDict>) -> PyResult<Model> {
    Model::derive(py, text, path, self::options("Model", Some(options))?)
}
