"""From a robot description to an exact symbolic model, generated code, and inertial parameters identified from logs of the robot."""

from os import PathLike
from typing import Any, Callable, Iterator, Literal, Mapping, Protocol, Sequence, TypeAlias, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

__version__: str

Numbers: TypeAlias = NDArray[np.float64]
Path: TypeAlias = str | PathLike[str]
Progress: TypeAlias = Callable[[int, int, str], object]

class Frame(Protocol):
    """A table of pandas, polars or pyarrow."""

    def __arrow_c_stream__(self, requested_schema: object | None = None) -> object: ...

Log: TypeAlias = Path | Mapping[str, Any] | Frame
Logs: TypeAlias = Log | Sequence[Log]

class Error(ValueError):
    """Input that cannot be used, or data that contradict the request."""

class TrustWarning(UserWarning):
    """A result that is not to be trusted, because its verdict is no."""

class Picture:
    """Charts as SVG, used if matplotlib is not installed. A notebook shows the charts; `save` writes them."""

    charts: dict[str, str]
    def __init__(self, charts: Mapping[str, str]) -> None: ...
    def save(self, path: Path) -> None:
        """Writes one chart to a file, or several charts into a directory, which is created if it does not exist."""
    def _repr_html_(self) -> str: ...

class BaseParameters:
    """The smallest set of parameters on which the torques depend."""

    @property
    def names(self) -> list[str]:
        """p names, in the order of the columns of `base_regressor`."""
    @property
    def units(self) -> list[str]:
        """SI units, one per parameter."""
    @property
    def rules(self) -> list[str]:
        """The regrouping rule of each base parameter: how it follows from the standard parameters, exact in the symbols of the
        description, "ZZR1 = ZZ1 + IA1 + .."."""
    @property
    def no_effect(self) -> list[str]:
        """Standard parameters without effect on the torques, by name."""
    @property
    def matrix(self) -> Numbers:
        """K, shape (p, p_s): X_base = K X_standard."""
    def __len__(self) -> int: ...
    def __getitem__(self, name: str | int) -> str:
        """The rule of a parameter by its name, base["ZZR1"], or by its index, as in a list."""
    def __contains__(self, name: object) -> bool: ...
    def __iter__(self) -> Iterator[str]:
        """The names."""
    def to_dict(self) -> dict[str, str]:
        """Rules by name."""
    def _repr_html_(self) -> str: ...

class Model:
    """A robot and the functions of its state, which take arrays (N, n) or (n,): rad (m), rad/s, rad/s^2."""

    def __init__(
        self,
        path: Path,
        *,
        value: Mapping[str, float] | None = None,
        arg: Mapping[str, str] | None = None,
        package: Mapping[str, str] | None = None,
        root: str | None = None,
        mimic: Literal["constraint", "independent"] = "constraint",
        angles: Literal["meant", "as-given"] = "meant",
        rotor_inertia: Literal["none", "actuated", "all"] | None = None,
        lock: Mapping[str, float] | None = None,
        base: Sequence[float] | None = None,
        floating_base: bool = False,
        any_size: bool = False,
    ) -> None:
        """A robot and the functions that follow from its description: base parameters, regressors, torques, source code.

        `Model(path)` reads a description (.yaml, .urdf, .xacro, .xml of MuJoCo, .par) and derives its dynamics, in the same way as
        `Model.read`. Functions of the state take arrays of shape (N, n), one state per row and one column per coordinate, or (n,)
        for one state: q in rad (m for a prismatic joint), dq in rad/s, ddq in rad/s^2. If dq or ddq is missing, it is zero. These
        functions release the interpreter lock. They do not copy float64 arrays in row-major order.

        >>> model = rist.Model("models/panda.yaml")
        >>> y = model.base_regressor(q, dq, ddq)     # (N, n, p)
        >>> w = y.reshape(-1, y.shape[-1])           # the observation matrix, (N n, p), without a copy

        Options:
        - value: Value of a symbol of the description, m or rad: D3=0.45. A .par file may have symbols without a value
        - arg: Value of an argument of a xacro, which the file uses as `$(arg NAME)` [default: as in the file]
        - package: Folder of a package, for includes of a xacro (`$(find NAME)`) or meshes and parts of an MJCF.
          Without this option, a xacro finds packages with a package.xml in the folders above the file
        - root: The robot to read, if a file has several: a body of the world of an MJCF, or a model of an SDF
          [default: all that is in the file]
        - mimic: How mimic joints of a URDF are read. constraint: they follow the joint that they mimic; independent:
          they are coordinates of their own [default: 'constraint']
        - angles: How rounded angles are read. meant: as the exact angles (1.5707 and 1.5708 as pi/2); as-given: as
          the numbers in the file [default: 'meant']
        - rotor_inertia: Joints that have a rotor inertia (IA) among their parameters [default: as in the file; if the
          file says nothing: actuated for YAML, none for URDF]
        - lock: Joints locked at a position, rad or m, such as a gripper that is not in the log: finger=0.02. Without
          this option, no joint is locked
        - base: Mount of the base, rad: roll, pitch and yaw of the base frame, in a frame in which gravity is as in
          the file. 3.1416,0,0 is a robot on a ceiling [default: as in the file]
        - floating_base: Let the base float: six coordinates come first (base_x, base_y, base_z, base_yaw, base_pitch,
          base_roll), and the base becomes a link with its own parameters [default: False]
        - any_size: Derive the model even if this takes more than about 10 s or 1 GiB. Otherwise such a model is
          refused, with an estimate of time and memory [default: False]"""
    @staticmethod
    def read(
        path: Path,
        *,
        value: Mapping[str, float] | None = None,
        arg: Mapping[str, str] | None = None,
        package: Mapping[str, str] | None = None,
        root: str | None = None,
        mimic: Literal["constraint", "independent"] = "constraint",
        angles: Literal["meant", "as-given"] = "meant",
        rotor_inertia: Literal["none", "actuated", "all"] | None = None,
        lock: Mapping[str, float] | None = None,
        base: Sequence[float] | None = None,
        floating_base: bool = False,
        any_size: bool = False,
    ) -> Model:
        """Reads a description (.yaml, .urdf, .xacro, .xml of MuJoCo, .par) and derives its dynamics. A warning names the angles of
        the file that are read as other angles (see angles). Raises rist.Error with the place that cannot be read.

        Options:
        - value: Value of a symbol of the description, m or rad: D3=0.45. A .par file may have symbols without a value
        - arg: Value of an argument of a xacro, which the file uses as `$(arg NAME)` [default: as in the file]
        - package: Folder of a package, for includes of a xacro (`$(find NAME)`) or meshes and parts of an MJCF.
          Without this option, a xacro finds packages with a package.xml in the folders above the file
        - root: The robot to read, if a file has several: a body of the world of an MJCF, or a model of an SDF
          [default: all that is in the file]
        - mimic: How mimic joints of a URDF are read. constraint: they follow the joint that they mimic; independent:
          they are coordinates of their own [default: 'constraint']
        - angles: How rounded angles are read. meant: as the exact angles (1.5707 and 1.5708 as pi/2); as-given: as
          the numbers in the file [default: 'meant']
        - rotor_inertia: Joints that have a rotor inertia (IA) among their parameters [default: as in the file; if the
          file says nothing: actuated for YAML, none for URDF]
        - lock: Joints locked at a position, rad or m, such as a gripper that is not in the log: finger=0.02. Without
          this option, no joint is locked
        - base: Mount of the base, rad: roll, pitch and yaw of the base frame, in a frame in which gravity is as in
          the file. 3.1416,0,0 is a robot on a ceiling [default: as in the file]
        - floating_base: Let the base float: six coordinates come first (base_x, base_y, base_z, base_yaw, base_pitch,
          base_roll), and the base becomes a link with its own parameters [default: False]
        - any_size: Derive the model even if this takes more than about 10 s or 1 GiB. Otherwise such a model is
          refused, with an estimate of time and memory [default: False]"""
    @staticmethod
    def parse(
        text: str,
        name: str = "robot.urdf",
        *,
        value: Mapping[str, float] | None = None,
        arg: Mapping[str, str] | None = None,
        package: Mapping[str, str] | None = None,
        root: str | None = None,
        mimic: Literal["constraint", "independent"] = "constraint",
        angles: Literal["meant", "as-given"] = "meant",
        rotor_inertia: Literal["none", "actuated", "all"] | None = None,
        lock: Mapping[str, float] | None = None,
        base: Sequence[float] | None = None,
        floating_base: bool = False,
        any_size: bool = False,
    ) -> Model:
        """Reads a description from a text. `name` is used in messages, and its ending (.yaml, .urdf or .par) gives the format.

        Options:
        - value: Value of a symbol of the description, m or rad: D3=0.45. A .par file may have symbols without a value
        - arg: Value of an argument of a xacro, which the file uses as `$(arg NAME)` [default: as in the file]
        - package: Folder of a package, for includes of a xacro (`$(find NAME)`) or meshes and parts of an MJCF.
          Without this option, a xacro finds packages with a package.xml in the folders above the file
        - root: The robot to read, if a file has several: a body of the world of an MJCF, or a model of an SDF
          [default: all that is in the file]
        - mimic: How mimic joints of a URDF are read. constraint: they follow the joint that they mimic; independent:
          they are coordinates of their own [default: 'constraint']
        - angles: How rounded angles are read. meant: as the exact angles (1.5707 and 1.5708 as pi/2); as-given: as
          the numbers in the file [default: 'meant']
        - rotor_inertia: Joints that have a rotor inertia (IA) among their parameters [default: as in the file; if the
          file says nothing: actuated for YAML, none for URDF]
        - lock: Joints locked at a position, rad or m, such as a gripper that is not in the log: finger=0.02. Without
          this option, no joint is locked
        - base: Mount of the base, rad: roll, pitch and yaw of the base frame, in a frame in which gravity is as in
          the file. 3.1416,0,0 is a robot on a ceiling [default: as in the file]
        - floating_base: Let the base float: six coordinates come first (base_x, base_y, base_z, base_yaw, base_pitch,
          base_roll), and the base becomes a link with its own parameters [default: False]
        - any_size: Derive the model even if this takes more than about 10 s or 1 GiB. Otherwise such a model is
          refused, with an estimate of time and memory [default: False]"""
    @property
    def name(self) -> str:
        """The name of the robot."""
    @property
    def path(self) -> PathLike[str]:
        """The file from which the description was read."""
    @property
    def coordinates(self) -> list[str]:
        """Names of the n coordinates, in the order of the columns of q."""
    @property
    def base_parameters(self) -> BaseParameters:
        """The p base parameters, with names, rules and matrix."""
    @property
    def standard_parameters(self) -> list[str]:
        """Names of the standard parameters, in the order of the columns of `regressor`: XX XY XZ YY YZ ZZ MX MY MZ M of each link
        about the origin of its frame (kg m^2, kg m, kg), and IA of each joint with a rotor inertia."""
    @property
    def nominal_parameters(self) -> Numbers | None:
        """Nominal base parameters, (p,), from the inertial parameters of the description; None if the description has none."""
    @property
    def described_parameters(self) -> Numbers | None:
        """The former name of `nominal_parameters`."""
    @property
    def is_compiled(self) -> bool:
        """Whether the base regressor is compiled into this package. Otherwise it is evaluated from a list of operations (a tape)."""
    def report(self, path: Path) -> None:
        """Writes the HTML page of `rist inspect`: the robot with its frames, and the base parameters with their meanings and
        rules."""
    def to_dict(self) -> dict[str, Any]:
        """The output of `rist inspect --format json`, as dicts, lists, texts and numbers."""
    def _repr_html_(self) -> str: ...
    def regressor(self, q: ArrayLike, dq: ArrayLike | None = None, ddq: ArrayLike | None = None) -> Numbers:
        """Y(q, dq, ddq) of the standard parameters, tau = Y X: shape (N, n, p_s), N m (N) per unit of the parameter."""
    def base_regressor(self, q: ArrayLike, dq: ArrayLike | None = None, ddq: ArrayLike | None = None) -> Numbers:
        """Y(q, dq, ddq) of the base parameters, tau = Y X: shape (N, n, p), N m (N) per unit of the parameter.

        reshape(-1, p) gives the observation matrix without a copy."""
    def torque(
        self,
        q: ArrayLike,
        dq: ArrayLike | None = None,
        ddq: ArrayLike | None = None,
        parameters: ArrayLike | Estimate | None = None,
    ) -> Numbers:
        """The joint torques without friction, shape (N, n), N m (N for a prismatic joint).

        parameters: p base parameters, p_s standard parameters, or an Estimate. Without this argument, the parameters of the
        description are used."""
    def inertia_matrix(self, q: ArrayLike, parameters: ArrayLike | Estimate | None = None) -> Numbers:
        """The inertia matrix A(q), shape (N, n, n), kg m^2; parameters as for `torque`."""
    def bias(self, q: ArrayLike, dq: ArrayLike | None = None, parameters: ArrayLike | Estimate | None = None) -> Numbers:
        """Coriolis, centrifugal and gravity torques, shape (N, n), N m (N); parameters as for `torque`."""
    def gravity(self, q: ArrayLike, parameters: ArrayLike | Estimate | None = None) -> Numbers:
        """Gravity torques, shape (N, n), N m (N); parameters as for `torque`."""
    def energy(
        self, q: ArrayLike, dq: ArrayLike | None = None, parameters: ArrayLike | Estimate | None = None
    ) -> Numbers:
        """Kinetic and potential energy, shape (N, 2), J; parameters as for `torque`. With base parameters, the potential energy is
        determined only up to a constant."""
    def forward_dynamics(
        self, q: ArrayLike, dq: ArrayLike | None, tau: ArrayLike, parameters: ArrayLike | Estimate | None = None
    ) -> Numbers:
        """The accelerations that follow from the torques tau, without friction, shape (N, n), rad/s^2 (m/s^2); parameters as for
        `torque`."""
    def torque_derivatives(
        self,
        q: ArrayLike,
        dq: ArrayLike | None = None,
        ddq: ArrayLike | None = None,
        parameters: ArrayLike | Estimate | None = None,
    ) -> tuple[Numbers, Numbers]:
        """Derivatives of the torques with respect to q and to dq, each (N, n, n), N m per rad and N m per rad/s. The derivative
        with respect to ddq is the inertia matrix."""
    def forward_dynamics_derivatives(
        self, q: ArrayLike, dq: ArrayLike | None, tau: ArrayLike, parameters: ArrayLike | Estimate | None = None
    ) -> tuple[Numbers, Numbers, Numbers]:
        """Derivatives of the accelerations with respect to q, dq and tau, each (N, n, n)."""
    def pose(self, link: str, q: ArrayLike, frame: str | None = None) -> Numbers:
        """Orientation and position of a link, (N, 3, 4), in the base frame, or in the frame of another link."""
    def jacobian(self, link: str, q: ArrayLike, frame: str | None = None) -> Numbers:
        """Jacobian of a link, (N, 6, n): the velocity of its origin, then its angular velocity. The axes are the axes of the link
        itself, or with `frame` the axes of another link or of "base"."""
    def evaluate(
        self,
        function: str,
        q: ArrayLike | None = None,
        dq: ArrayLike | None = None,
        ddq: ArrayLike | None = None,
        parameters: ArrayLike | Estimate | None = None,
        **others: ArrayLike,
    ) -> Numbers | dict[str, Numbers]:
        """Any function of `rist generate` by its name ("coriolis-matrix", "velocity=LINK", "inverse-geometry=LINK", ..). Returns
        the output, or a dict of outputs by name if there are several. Inputs other than q, dq, ddq and parameters are given by
        keyword, one row per state: tau=, wrench=, point=, t=, dq_r=, ddq_r=."""
    @overload
    def generate(
        self,
        language: Literal["rust"] = "rust",
        functions: Sequence[str] = ...,
        header: str | None = None,
        *,
        estimate: Estimate | None = None,
        anyway: bool = False,
        symbols: Sequence[str] = ...,
    ) -> str: ...
    @overload
    def generate(
        self,
        language: Literal["c"],
        functions: Sequence[str] = ...,
        header: str | None = None,
        *,
        estimate: Estimate | None = None,
        anyway: bool = False,
        symbols: Sequence[str] = ...,
    ) -> tuple[str, str]: ...

class Verdict:
    """Whether to trust a result."""

    @property
    def trust(self) -> Literal["yes", "with care", "no"]:
        """"yes", "with care" or "no"."""
    @property
    def found(self) -> str:
        """What was found."""
    @property
    def reasons(self) -> list[str]:
        """The reasons of the verdict, the most important first."""
    @property
    def next(self) -> str:
        """The next step: what to do now."""
    @property
    def uses(self) -> dict[str, Literal["yes", "with care", "no"]]:
        """The verdict for each use, by the name of the use: "yes", "with care" or "no"."""
    @property
    def torque_errors(self) -> dict[str, float | None]:
        """Relative uncertainty of the torque for each use, by the name of the use; None if it is not known."""
    @property
    def claims(self) -> list[str]:
        """All claims that were checked, each with its evidence."""
    def to_dict(self) -> dict[str, Any]:
        """trust, found, reasons, next, uses, torque_errors and claims by their names."""
    def _repr_html_(self) -> str: ...

class Estimate:
    """Identified parameters with their standard deviations, the residuals, and what the data do not determine."""

    @staticmethod
    def read(path: Path, model: Model | Path | None = None) -> Estimate:
        """Reads estimate.yaml. With its model, the estimate can predict other logs. Raises rist.Error if the estimate was made
        with another model."""
    @property
    def model(self) -> Model | None:
        """The model with which the estimate was made. It may have rotor inertias that a URDF cannot contain. None if the estimate
        was read without its model."""
    @property
    def validation(self) -> Validation | None:
        """How well the estimate predicts the logs of validate=; None without such logs."""
    @property
    def notes(self) -> list[str]:
        """Assumptions of a simulation about what the description does not say, as sentences."""
    def __getitem__(self, name: str | int) -> float | None:
        """A value by its name, estimate["ZZR1"], or by its index, as in a list. None if the data do not determine the value. If
        the name is unknown, KeyError proposes a similar name."""
    def __contains__(self, name: object) -> bool: ...
    def __len__(self) -> int: ...
    def __iter__(self) -> Iterator[str]:
        """The names."""
    def to_dict(self) -> dict[str, Any]:
        """The content of estimate.yaml, as dicts, lists, texts and numbers."""
    def plot(self, log: Logs | None = None) -> Any:
        """Draws measured and identified torques of a log joint by joint, and the residual. Without `log`, the logs are drawn from
        which the estimate was made. For an estimate from experiments, its parameters are drawn. Returns axes of matplotlib;
        without matplotlib, a rist.Picture of the page."""
    def _repr_html_(self) -> str: ...
    @property
    def names(self) -> list[str]:
        """Names of the parameters: base parameters, then friction, couplings and drive gains."""
    @property
    def units(self) -> list[str]:
        """SI units, one per parameter."""
    @property
    def parameters(self) -> dict[str, float | None]:
        """Values by name; None if the data do not determine the value."""
    @property
    def values(self) -> Numbers:
        """Values; NaN if the data do not determine the value."""
    @property
    def sigma(self) -> Numbers:
        """Standard deviations, in the units of the values. Use these, and not `white_sigma`."""
    @property
    def white_sigma(self) -> Numbers:
        """Standard deviations under the assumption that the model is exact and the noise is white."""
    @property
    def status(self) -> list[str]:
        """Status of each value: "identified", "not_significant", "weak", "not_identifiable", or "given" if it was not estimated."""
    @property
    def table(self) -> dict[str, Any]:
        """A dict of columns (name, value, sigma, white_sigma, unit, status) for pandas.DataFrame and polars.DataFrame. A value
        that the data do not determine is NaN in this dict, and null in the Arrow table."""
    def __arrow_c_stream__(self, requested_schema: object | None = None) -> object:
        """The table as an Arrow stream, for pyarrow.table(estimate) and polars.DataFrame(estimate)."""
    @property
    def covariance(self) -> Numbers | None:
        """The covariance of the values, (P, P), for white noise; None unless identify was called with covariance=True."""
    @property
    def remarks(self) -> list[str]:
        """Sentences on what the data do not determine."""
    @property
    def findings(self) -> list[str]:
        """Contradictions between the logs and the description (units, signs, columns), as sentences, the worst first."""
    @property
    def load(self) -> str | None:
        """The load on the last link, as the program prints it; None without loaded logs."""
    @property
    def verdict(self) -> Verdict:
        """Whether to trust the estimate, and why."""
    @property
    def total(self) -> float | None:
        """Relative residual |tau - W X| / |tau| over all joints; None if no torques were fitted."""
    @property
    def cross_validation(self) -> float | None:
        """Relative residual on held-out tenths of the log: each tenth is predicted from the other tenths. None for estimates from
        the experiments of a plan."""
    @property
    def cutoff(self) -> float | None:
        """Cut-off of the low-pass, Hz; None if nothing was filtered."""
    @property
    def condition_number(self) -> float | None:
        """Condition number of the columns of the observation matrix, scaled to unit norm; None if there was no such matrix."""
    @property
    def rank(self) -> int:
        """Number of parameters, or combinations of them, that the data determine."""
    @property
    def rows(self) -> int:
        """Number of rows of all joints."""
    @property
    def joints(self) -> dict[str, list[Any]]:
        """Residuals of the joints: a dict of columns (coordinate, rms, unit, relative, held_out)."""
    def predict(self, log: Logs | None = None) -> Any:
        """Measured torques of a log, and torques predicted by the estimate, both filtered as in the fit. Returns a dict: t (N,) in
        s, measured and predicted (N, n) in N m (N); for several logs, a list of such dicts. Rows that do not count, at
        standstill, are NaN. Without `log`, the logs are used from which the estimate was made."""
    def to_yaml(self) -> str:
        """The text of estimate.yaml, byte for byte the same as the file of the program."""
    def save(self, path: Path) -> None:
        """Writes estimate.yaml."""
    def report(
        self,
        path: Path,
        plan: ExperimentPlan | None = None,
        validation: Validation | None = None,
        date: str | None = None,
        log: Logs | None = None,
    ) -> None:
        """Writes one self-contained HTML page: the verdict, torques and residuals, the parameters with their rules and meanings,
        and the plan and the validation if they are given. The torques are those of `log`, or of the logs from which the
        estimate was made, if these logs still exist."""
    def write_urdf(self, path: Path, anyway: bool = False) -> list[str]:
        """Writes the URDF of the model with the identified bodies, joint damping and friction; needs consistent=True.

        Returns sentences on what a URDF cannot contain. Raises rist.Error if the verdict is no, unless anyway=True."""
    def write_mjcf(self, path: Path, anyway: bool = False) -> None:
        """Writes a MuJoCo model with the identified inertials, damping, friction loss and armature; needs consistent=True. If the
        model was read from an MJCF, the rest of that file is kept."""

class Validation:
    """How well an estimate predicts logs from which it was not made."""

    @staticmethod
    def read(path: Path) -> Validation:
        """Reads the YAML file that `save` writes."""
    @staticmethod
    def from_yaml(text: str) -> Validation:
        """Makes the object from the text of `to_yaml`."""
    def to_yaml(self) -> str:
        """The text of the file, byte for byte the same as the file of the program."""
    def to_dict(self) -> dict[str, Any]:
        """The content of the file, as dicts, lists, texts and numbers."""
    def _repr_html_(self) -> str: ...
    def save(self, path: Path) -> None:
        """Writes the YAML file."""
    def report(self, path: Path, date: str | None = None) -> None:
        """Writes one self-contained HTML page."""
    def plot(self) -> Any:
        """Draws the relative errors by joint and by log. Returns axes of matplotlib; without matplotlib, a rist.Picture."""
    @property
    def total(self) -> float:
        """Relative error |tau - tau_predicted| / |tau| over all joints and logs."""
    @property
    def joints(self) -> dict[str, list[Any]]:
        """Errors of the joints: a dict of columns (coordinate, relative, rms, unit), one row per joint."""
    @property
    def logs(self) -> dict[str, float]:
        """Relative errors by log."""

class ExperimentPlan:
    """Experiments for identification by spectrum analysis, with the accuracy that they promise."""

    @staticmethod
    def read(path: Path) -> ExperimentPlan:
        """Reads the YAML file that `save` writes."""
    @staticmethod
    def from_yaml(text: str) -> ExperimentPlan:
        """Makes the object from the text of `to_yaml`."""
    def to_yaml(self) -> str:
        """The text of the file, byte for byte the same as the file of the program."""
    def to_dict(self) -> dict[str, Any]:
        """The content of the file, as dicts, lists, texts and numbers."""
    def _repr_html_(self) -> str: ...
    def save(self, path: Path) -> None:
        """Writes the YAML file."""
    @property
    def names(self) -> list[str]:
        """Names of the experiments: their logs are e01.csv, .."""
    def write_trajectories(
        self, directory: Path, rate: float, format: Literal["csv", "yaml", "json"] = "csv"
    ) -> None:
        """Writes each motion into a directory, as a file that a controller can play, sampled at `rate` Hz: "csv", or a
        JointTrajectory of ROS as "yaml" or "json"."""
    def report(self, path: Path, date: str | None = None, model: Model | Path | None = None) -> None:
        """Writes one self-contained HTML page. With the model, or the path of its description, the limits of each experiment and
        the guaranteed efficiency of the plan are proved again. Without a model, the page shows the statements of the file."""

class ExcitingMotion:
    """One motion of all joints that excites the parameters, with the proof that it keeps its limits."""

    @staticmethod
    def read(path: Path) -> ExcitingMotion:
        """Reads the YAML file that `save` writes."""
    @staticmethod
    def from_yaml(text: str) -> ExcitingMotion:
        """Makes the object from the text of `to_yaml`."""
    def to_yaml(self) -> str:
        """The text of the file, byte for byte the same as the file of the program."""
    def to_dict(self) -> dict[str, Any]:
        """The content of the file, as dicts, lists, texts and numbers."""
    def _repr_html_(self) -> str: ...
    def save(self, path: Path) -> None:
        """Writes the YAML file."""
    @property
    def proven(self) -> bool:
        """Whether every checked limit is proven, also between the samples, and every requested check was possible."""
    @property
    def notes(self) -> list[str]:
        """Assumptions about what the description does not say, as sentences."""
    @property
    def condition_number(self) -> float:
        """Condition number of the scaled columns of the parameters that the motion excites."""
    def trajectory(self) -> str:
        """The motion to play, sampled at `rate_hz`, as a text in CSV."""
    def report(self, path: Path, date: str | None = None, model: Model | Path | None = None) -> None:
        """Writes one self-contained HTML page: the motion within its limits, the path of the tip, and the parameters that the
        motion excites. For a motion from a file, give its model, or the path of the description: only then is everything drawn,
        and the limits are proved again."""
    def write_play(self, path: Path, unproven: bool = False, model: Model | Path | None = None) -> None:
        """Writes the motion for a controller to play. The end of the file name selects the format: .csv, .yaml or .json (ROS
        JointTrajectory), .script (URScript servoj). Raises rist.Error if the limits are not proven, unless unproven=True."""
    def plot(self) -> Any:
        """Draws positions and velocities over time, with the limits of the positions. Returns axes of matplotlib; without
        matplotlib, a rist.Picture of the page."""

class LogCheck:
    """The result of checking that logs belong to a description."""

    @property
    def findings(self) -> list[str]:
        """What is wrong, the worst first: for each finding a sentence, with its remedy."""
    @property
    def not_checked(self) -> list[str]:
        """Checks that were not possible, each with its reason."""
    @property
    def untold(self) -> list[str]:
        """The former name of `not_checked`."""
    @property
    def is_gross(self) -> bool:
        """Whether a finding makes an estimate from these logs unusable."""
    @property
    def joints(self) -> dict[str, list[Any]]:
        """How each joint agrees with the description, a dict of columns: coordinate; slope, the measured torque per torque of the
        description; share, the part of the torque on which the slope is based; explained, the part of the torque that is
        explained together with rotor, friction and offset; range, the range of motion, rad (m)."""
    @property
    def claims(self) -> list[str]:
        """All claims that were checked: which are contradicted, which agree and what fault they would have shown, and which cannot
        be determined."""
    def to_dict(self) -> dict[str, Any]:
        """findings, not_checked, is_gross, joints and claims by their names."""
    def plot(self) -> Any:
        """Draws the slope of each joint, which is 1 if log and description agree. Returns axes of matplotlib; without matplotlib,
        a rist.Picture."""
    def _repr_html_(self) -> str: ...

class Accumulator:
    """Sums over logs of one robot."""

    def __init__(
        self,
        model: Model | Path,
        *,
        gain: Mapping[str, float] | None = None,
        friction: str | Sequence[str] | None = None,
        weights: Literal["none", "joint", "huber", "bisquare"] | None = None,
        cutoff: float | None = None,
        order: int | None = None,
        rate: float | None = None,
        decimate: int | None = None,
        delay: float | Literal["auto"] | None = None,
        options: Path | Mapping[str, Any] | None = None,
    ) -> None:
        """Sums over logs of one robot: what a fit needs of the logs, without their rows. `update` adds a log, `merge` adds other sums,
        and `solve` computes the estimate without the logs.

        All sums that will be merged need the same cut-off (Hz) and the same options: cutoff, order, decimate, delay, friction,
        weights ("none", "joint"), gain ({"q1": 2.393}, N m/A), options, as for `identify`. A pickle of an accumulator has some
        kilobytes, so the worker processes of any engine can make accumulators. Merged in any order, the result is the same as from
        one pass over all logs, up to rounding.

        >>> sums = rist.Accumulator(model, cutoff=10.0)
        >>> sums.update("monday.mcap").merge(other)
        >>> estimate = sums.solve()

        Options:
        - gain: Gain of every drive (torque per current), N m/A [default: as in the description]
        - friction: Friction terms of every joint: viscous, coulomb, offset, asymmetric, load, rotor,
          smooth-coulomb=V, stribeck=V (V in rad/s), none; or auto, which chooses the terms that best predict held-out
          parts of the logs [default: viscous,coulomb,offset]
        - weights: Weights of the rows in the fit [default: joint]
        - cutoff: Cut-off of the zero-phase low-pass, Hz [default: from the frequency content of the logs]
        - order: Order of the Butterworth low-pass; 0: no low-pass [default: 4]
        - rate: Rows per second (Hz) of a log without a clock
        - decimate: Keep every N-th filtered sample [default: from the cut-off]
        - delay: Delay of the torques behind the positions, s; negative if the torques come first [default: 0]. auto:
          the delay within +-0.25 s with the smallest residual, on rows away from reversals of their joint. With this
          delay, the residual of all rows may be larger than without
        - options: YAML with any option of an identification. Other options that are given here replace those of the
          file"""
    def update(self, log: Logs, anyway: bool = False) -> Accumulator:
        """Adds a log, or a list of logs, as for `identify`. Returns itself.

        Raises rist.Error if a log cannot be used, is in the sums already, or does not belong to the model. Nothing of this log
        is added then. With anyway=True, a log that does not belong to the model is added."""
    def merge(self, other: Accumulator) -> Accumulator:
        """Adds the logs of another accumulator. Returns itself. Raises rist.Error if the settings differ, and says which, or if a
        log is in both."""
    def fail(self, log: str, reason: str) -> None:
        """Notes a log that could not be used. Every estimate from the sums then names this log."""
    def solve(self) -> Estimate:
        """The estimate from all logs in the sums."""
    @property
    def logs(self) -> list[str]:
        """Names of the logs in the sums."""
    @property
    def samples(self) -> int:
        """Number of samples in the sums, after the filter."""
    @property
    def failed(self) -> list[tuple[str, str]]:
        """Logs that could not be used, each with the reason."""
    def to_bytes(self) -> bytes:
        """The content of the .tri file of the program."""
    def save(self, path: Path) -> None:
        """Writes the .tri file of the program."""
    @staticmethod
    def read(path: Path, model: Model | Path) -> Accumulator:
        """Reads a .tri file. Raises rist.Error if the file is not a .tri file, is incomplete, or is of another model."""
    def __len__(self) -> int: ...

class Comparison:
    """What changed between sums."""

    @staticmethod
    def read(path: Path) -> Comparison:
        """Reads the YAML file that `save` writes."""
    @staticmethod
    def from_yaml(text: str) -> Comparison:
        """Makes the object from the text of `to_yaml`."""
    def to_yaml(self) -> str:
        """The text of the file, byte for byte the same as the file of the program."""
    def to_dict(self) -> dict[str, Any]:
        """The content of the file, as dicts, lists, texts and numbers."""
    def _repr_html_(self) -> str: ...
    def save(self, path: Path) -> None:
        """Writes the YAML file."""
    @property
    def changed(self) -> list[str]:
        """Names of the robots that changed."""
    @property
    def moved(self) -> dict[str, dict[str, tuple[float, float]]]:
        """Parameters that changed, by the name of the robot: dicts of name -> (difference, sigma), in the unit of the parameter."""

def identify(
    model: Model | Path,
    logs: Logs,
    *,
    consistent: bool = False,
    free_bodies: bool = False,
    gain: Mapping[str, float | tuple[float, float]] | None = None,
    arm: str | None = None,
    unknowns: Sequence[Literal["mount", "zeros", "scales", "springs"]] | None = None,
    leave_out_contact: bool = False,
    covariance: bool = False,
    loaded_link: str | None = None,
    friction: str | Sequence[str] | None = None,
    weights: Literal["none", "joint", "huber", "bisquare"] | None = None,
    cutoff: float | None = None,
    order: int | None = None,
    rate: float | None = None,
    decimate: int | None = None,
    delay: float | Literal["auto"] | None = None,
    options: Path | Mapping[str, Any] | None = None,
    load: Path | Mapping[str, Any] | None = None,
    ripple: float | Sequence[float] | Mapping[str, float | Sequence[float]] | None = None,
    spring: bool | str | Sequence[str] = False,
    eccentric: bool | str | Sequence[str] = False,
    elastic: bool | str | Sequence[str] = False,
    backlash: bool | str | Sequence[str] = False,
    method: Literal["ls", "essential", "rist", "tls", "rist-mh", "iv", "didim"] = "ls",
    loaded: Logs = (),
    validate: Logs = (),
    plan: ExperimentPlan | Path | None = None,
    rotor_inertia: Literal["none", "actuated", "all"] | None = None,
) -> Estimate:
    """Identifies the base parameters and the friction of a robot from its logs. If the verdict is no, a rist.TrustWarning says so.

    model: a Model, or the path of a description. logs: one log or a list of logs. A log is a path (CSV, .npz, Arrow, Parquet,
    MCAP, a rosbag2 directory), a dict of arrays ({"t": (N,), "q": (N, n), "tau": (N, n)}; SI units), or a table with
    __arrow_c_stream__ (pandas, polars, pyarrow). With method="rist", "tls", "rist-mh", "iv" or "didim", logs is the directory
    with the logs of `plan`.

    Options:
    - consistent: Identify physically consistent parameters: every link is a body that can exist. A body that the
      logs do not determine stays near the body of the description [default: False]
    - free_bodies: Never constrain the links to bodies that can exist. Without this option, the links are
      constrained if a log is poor and held-out parts of it are then predicted better [default: False]
    - gain: Drive gain (torque per current), N m/A [default: as in the file]. If only some gains are given, the
      others are estimated. q5=11+-2: a gain near 11 is expected, with standard deviation 2
    - arm: A hobby arm or its servo: so101, koch, wx250s, vx300s, openmanipulator-x, xm430-w350 and others. Units,
      zeros and gains of this arm are used where nothing else gives them. The form of the positions may follow the
      name: so101:degrees, :normalised, :counts or :radians
    - unknowns: What to identify in addition to the parameters, for all joints: mount (of the base), zeros (of the
      positions), scales (of the torques), springs. The estimate gives each value with its deviation, and the
      option or the line of the URDF that corrects it
    - leave_out_contact: Leave out the rows of intervals in which the residual is an outlier, for example during a
      contact. The estimate lists these intervals [default: False]
    - covariance: Keep the covariance of the parameters in the estimate [default: False]
    - loaded_link: The link that carries the load in the logs of loaded= [default: the last link]
    - friction: Friction terms of every joint: viscous, coulomb, offset, asymmetric, load, rotor,
      smooth-coulomb=V, stribeck=V (V in rad/s), none; or auto, which chooses the terms that best predict held-out
      parts of the logs [default: viscous,coulomb,offset]
    - weights: Weights of the rows in the fit [default: joint]
    - cutoff: Cut-off of the zero-phase low-pass, Hz [default: from the frequency content of the logs]
    - order: Order of the Butterworth low-pass; 0: no low-pass [default: 4]
    - rate: Rows per second (Hz) of a log without a clock
    - decimate: Keep every N-th filtered sample [default: from the cut-off]
    - delay: Delay of the torques behind the positions, s; negative if the torques come first [default: 0]. auto:
      the delay within +-0.25 s with the smallest residual, on rows away from reversals of their joint. With this
      delay, the residual of all rows may be larger than without
    - options: YAML with any option of an identification. Other options that are given here replace those of the
      file
    - load: A known load: YAML with link, mass (kg), centre_of_mass (m) and inertia about the centre of mass (kg
      m^2). The logs of the experiments with the load, e01_loaded.csv, .., are in the folder of the other logs.
      With a load, no gain needs to be known
    - ripple: Estimate ripple of torque and gain with this number of periods per turn of the joint, for one
      coordinate or for all
    - spring: Estimate a spring in parallel with the motor, for example one that balances gravity, for these
      coordinates or for all [default: False]
    - eccentric: Estimate the error that an encoder has once per turn, for these coordinates or for all [default:
      False]
    - elastic: Estimate a spring between motor and link, for these coordinates or for all. It is assumed that the
      encoders are at the motors. The equations then end at 10 Hz, unless cutoff= is given [default: False]
    - backlash: Estimate the backlash between motor and link, for these coordinates or for all. The assumption and
      the equations are as for elastic= [default: False]
    - method: Method of identification. All methods except ls and essential need plan=, the plan whose experiments
      are in the logs [default: 'ls']
    - loaded: Logs with a load on the last link; the load is identified too
    - validate: Logs that are not fitted, but predicted, for the verdict
    - plan: The plan whose experiments are in the logs
    - rotor_inertia: Joints that have a rotor inertia (IA) among their parameters [default: as in the file; if the
      file says nothing: actuated for YAML, none for URDF]

    With method="rist-mh", you can also estimate: ripple (periods per turn of all joints, or {"q2": 12}, or {"q2": [6, 12]});
    elastic and backlash (True for all joints, or ["q2", "q3"]: springs and gaps between the motors, which have the encoders,
    and the links); delay="auto". With elastic or backlash, the equations end at 10 Hz, unless cutoff is given. cutoff is the
    highest frequency of the equations (default 20 Hz).

    Ctrl-C ends the identification. If something is wrong, raises rist.Error with the message of the program."""
def validate(
    model: Model | Path,
    estimate: Estimate,
    logs: Logs,
    *,
    gain: Mapping[str, float] | None = None,
    cutoff: float | None = None,
) -> tuple[Validation, Verdict]:
    """Predicts logs with an estimate, and compares measured and predicted torques. Returns a Validation and a Verdict. If the
    verdict is no, a rist.TrustWarning says so.

    model: the Model of the estimate, or its path. logs: as for `identify`. For an estimate from the experiments of a plan, logs
    are the paths of motions, and you can give gain={"q1": 2.4} (N m/A) and cutoff (Hz, default 20).

    Options:
    - gain: Drive gain (torque per current), N m/A [default: from the estimate; otherwise from the description;
      otherwise 1]
    - cutoff: Cut-off of the low-pass on position and torque, Hz [default: 20; an estimate from samples uses its
      own cut-off]"""
def doctor(
    model: Model | Path,
    logs: Logs,
    *,
    options: Path | Mapping[str, Any] | None = None,
    gain: Mapping[str, float] | None = None,
    arm: str | None = None,
    rate: float | None = None,
) -> LogCheck:
    """Checks logs for mistakes before anything is fitted: units, signs, zeros, swapped columns, another robot.

    model, logs: as for `identify`. options: a path to YAML with any option of an identification, its text, or its content as a
    dict. gain: {"q1": 2.393}, N m/A.

    Options:
    - options: YAML with any option of an identification
    - gain: Drive gain (torque per current), N m/A; negative if the current counts in the opposite direction
      [default: as in the file]
    - arm: A hobby arm or its servo: so101, koch, wx250s, vx300s, openmanipulator-x, xm430-w350 and others. Units,
      zeros and gains of this arm are used where nothing else gives them. The form of the positions may follow the
      name: so101:degrees, :normalised, :counts or :radians
    - rate: Rows per second (Hz) of a log without a clock"""
def plan(
    model: Model | Path,
    *,
    experiments: int = 8,
    criterion: Literal["determinant", "condition"] = "determinant",
    profile: Literal["bang-bang", "smooth"] = "bang-bang",
    steps: int = 5,
    configurations: int = 60,
    limits: Path | Mapping[str, Any] | None = None,
    effort_share: float = 0.9,
    duration: float = 4.0,
    rate: float = 1000.0,
    starts: int = 12,
    seed: int = 1,
    nodes: int = 0,
    progress: Progress | None = None,
) -> ExperimentPlan:
    """Chooses the experiments with which a robot is identified best by spectrum analysis. If the description lacks data, one
    warning lists the assumptions.

    model: a Model, or the path of a description.

    Options:
    - experiments: Number of experiments [default: 8]
    - criterion: What the choice of the experiments optimises [default: 'determinant']
    - profile: Profile of the acceleration within a swing, which is a motion between two positions and back
      [default: 'bang-bang']
    - steps: Number of grid positions of each coordinate [default: 5]
    - configurations: Maximum number of configurations for each kind of motion [default: 60]
    - limits: YAML with tighter limits of joints and bodies, as for limits= of `rist excite`
    - effort_share: Share of the limits of effort that the torque computed from the description may use [default:
      0.9]
    - duration: Recorded time of one experiment, s [default: 4.0]
    - rate: Sample rate of the controller, Hz [default: 1000.0]
    - starts: Number of starts of the search [default: 12]
    - seed: Seed of the random starts; the same seed gives the same plan [default: 1]
    - nodes: Maximum number of nodes of a branch-and-bound search; 0: no such search. The search improves the
      plan, and proves how far the plan can be from the best plan. It ends when the D-efficiency is within 0.001
      of the best. The proof is written into the plan [default: 0]
    - progress: Called with (done, all, text) during the work"""
def simulate(
    model: Model | Path,
    plan: ExperimentPlan | ExcitingMotion | Path,
    *,
    validation: int = 10,
    gain: Mapping[str, float] | None = None,
    load: Path | Mapping[str, Any] | None = None,
    feedforward: Estimate | None = None,
    seed: int = 1,
    noise_free: bool = False,
    out: Path | None = None,
    progress: Progress | None = None,
) -> tuple[Estimate, dict[str, dict[str, Numbers]]]:
    """Simulates the experiments of a plan, or an ExcitingMotion, in closed loop, with friction, noise and drive gains. `.notes` of
    the returned estimate lists the assumptions about what the description does not say.

    model: a Model, or the path of a description. plan: a plan or a motion, or the path of one.

    With out="DIRECTORY", writes the same files as `rist simulate`: one log per experiment (e01.csv, ..) or motion.csv, logs of
    other motions for validation (v01.csv, ..), truth.yaml, and with a load also e01_loaded.csv, .. and truth_loaded.yaml.
    Returns an Estimate with the true parameters behind the logs, and a dict of the logs by name. A log is a dict of arrays that
    `identify` takes: t (N,) in s, q (N, n) in rad (m), and i (N, n) in A, or tau (N, n) in N m (N) if no drive gain is known.

    Options:
    - validation: Number of validation motions [default: 10]
    - gain: Drive gain (torque per current), N m/A [default: as in the file; if only some gains are known, 1 for
      the others]
    - load: A known load, in a file as for load= of `rist identify`. Every experiment is repeated with this load:
      e01_loaded.csv, ..
    - feedforward: Estimate from which the controller computes feedforward torques
    - seed: Seed of the noise; the same seed gives the same logs [default: 1]
    - noise_free: Simulate sensors without noise and without rounding [default: False]
    - out: Directory to which the logs are written
    - progress: Called with (done, all, text) during the work"""
def excite(
    model: Model | Path,
    *,
    motion: Literal["fourier", "spline"] = "fourier",
    period: float | None = None,
    frequency: float | None = None,
    harmonics: int | None = None,
    spans: int | None = None,
    repetitions: int = 3,
    blend: float | None = None,
    rate: float = 200.0,
    limits: Path | Mapping[str, Any] | None = None,
    effort_share: float = 0.9,
    friction: str | Sequence[str] | None = None,
    criterion: Literal["determinant", "condition"] = "determinant",
    noise: float = 0.01,
    starts: int = 12,
    iterations: int = 100,
    seed: int = 1,
    after: Estimate | None = None,
    progress: Progress | None = None,
) -> ExcitingMotion:
    """Searches for one motion of all joints that excites the parameters, and proves that the motion keeps its limits. Look at
    `.proven` before you play the motion: it is False if the proof failed.

    model: a Model, or the path of a description.

    Options:
    - motion: The form of the motion [default: 'fourier']
    - period: Period of the series, or duration of a spline from rest to rest, s [default: from the limits, 5 to
      20]
    - frequency: Base frequency of the series, Hz: the inverse of period=. Give only one of the two options
    - harmonics: Number of harmonics of the base frequency [default: from the limits and the period, 5 to 8; 5 for
      more than 8 joints]
    - spans: Number of polynomial segments (spans) of a spline. With more spans the motion is freer, and the
      search is longer [default: from the limits, 8 to 30]
    - repetitions: Number of whole periods between the blends, or of repetitions of a spline [default: 3]
    - blend: Duration of the blend from rest to the series, and of the blend back to rest, s [default: from the
      limits]
    - rate: Sample rate of the file to play and of the log, Hz [default: 200.0]
    - limits: YAML with tighter limits. `coordinates: {NAME: {position: [LOW, HIGH], velocity, acceleration, jerk,
      effort, power, locked: POSITION, slowed: FACTOR}}` limits single coordinates; `all:` limits every coordinate
      in the same way. `space:` limits the bodies, in the base frame, m: `{floor: Z or none, walls: [{point,
      normal, links}], boxes: [{low, high, links}], distance: 0.01, own_links: true, accept: [[LINK, LINK,
      REASON]]}`. `margins:` has the errors for which the proof must hold too: `{encoder_zero, tracking,
      calibration, mesh, payload: {link, mass, centre_of_mass}}`
    - effort_share: Share of the limits of effort and power that the computed torque may use [default: 0.9]
    - friction: Friction terms of every joint in the later identification. The words and the default are those of
      friction= of `rist identify`; auto is not possible
    - criterion: What the search of the motion optimises [default: 'determinant']
    - noise: Standard deviation of the noise of a torque sample, as a share of the effort limit [default: 0.01]
    - starts: Number of starts of the search. A third of them are random; the others begin near the best motion so
      far [default: 12]
    - iterations: Maximum number of iterations of each start, at each weight of the barrier function for the
      limits [default: 100]
    - seed: Seed of the random starts; the same seed gives the same motion [default: 1]
    - after: The motion excites the parameters that this estimate leaves uncertain
    - progress: Called with (done, all, text) during the work"""
def check(
    model: Model | Path,
    motion: ExcitingMotion | Path,
    *,
    limits: Path | Mapping[str, Any] | None = None,
    after: Estimate | None = None,
    interpolation: Literal["linear", "cubic", "quintic"] | None = None,
) -> list[str]:
    """Proves again that a motion keeps its limits, and also the limits in `limits` (a path to YAML, or its content as a dict). The
    torques follow from the description, or from the estimate `after`. Of a plan, each experiment is proved in this way, and the
    efficiency that the proof of the plan guarantees is computed again. Returns a list of faults. The list is empty if every
    checked limit is proven, and every check that `limits` asks for was possible.

    model: a Model, or the path of a description. motion: an ExcitingMotion, an ExperimentPlan, or the path of a file: of a
    motion, a plan, a table of points (CSV) or a JointTrajectory (YAML, JSON).

    Options:
    - limits: YAML with further limits that the motion must keep, in the form of limits= of `rist excite`. A limit
      that is not in this file is not assumed. A check is left out (`space: {floor: none, accept: ..}`) only if
      this file says so
    - after: The torques in the proofs of effort and power follow from this estimate
    - interpolation: How the controller interpolates between the points of a table or a JointTrajectory [default:
      the smoothest way that the points allow]"""
def compare(
    reference: Accumulator,
    robots: Mapping[str,
    Accumulator],
    *,
    of: Literal["all", "inertial"] = "all",
    fdr: float = 0.05,
) -> Comparison:
    """Compares the sums of robots with the sums of a reference. robots: sums by name, {"r07": Accumulator, ..}.

    Options:
    - of: The parameters to compare [default: 'all']
    - fdr: False discovery rate: the expected share of unchanged robots among the robots reported as changed, and
      of unchanged parameters among the reported parameters [default: 0.05]"""
def wrench(
    log: Log,
    *,
    options: Path | Mapping[str, Any] | None = None,
    link: str = "tool0",
) -> dict[str, Any]:
    """Identifies the load on a force-torque sensor from a log: forces and torques in the axes of the sensor, and poses of the
    sensor in a frame at rest whose z axis points up.

    log: a path (CSV, .npz, Arrow, Parquet, MCAP, a rosbag2 directory), a dict of arrays, or a table with __arrow_c_stream__
    (pandas, polars, pyarrow). Columns are found by their names: fx fy fz tx ty tz, x y z, qx qy qz qw or roll pitch yaw.
    Without a clock, each row is a posture at rest. options: a path to YAML, its text, or its content as a dict.

    Returns a dict. parameters: in the frame of the sensor, about its origin. body: mass, centre of mass, and inertia about the
    centre of mass; None if the log does not determine a body that can exist, or if trust is "no". offsets: of the sensor.
    is_reaction: whether the sensor gives the force of the load on the sensor. residuals: N and N m. rows, left_out. verdict:
    with trust, reasons, next and claims. text: what the program prints.

    >>> rist.wrench("log.csv")["body"]

    Options:
    - options: YAML with the columns of the log, and with corrections of its numbers
    - link: Name of the link whose frame is the frame of the sensor. The file of the load contains this name
      [default: 'tool0']"""
def replay(
    model: Model | Path,
    estimate: Estimate,
    log: Log,
    *,
    reference: Sequence[Path] | None = None,
    alarms: float = 1.0,
    observer_gain: float = 50.0,
    order: Literal["first", "second"] = "first",
    load_on: str | None = None,
    largest_load: float = 10.0,
    wrench_on: str | None = None,
    anyway: bool = False,
) -> dict[str, Any]:
    """Finds contact, loads and drift of friction in a log, cycle by cycle, in the same way as on the robot.

    model: the Model of the estimate, or its path. log: as for `identify`. The estimate should contain its covariance.

    Returns a dict. contacts, loads, joints: lists of dicts. threshold: in standard deviations. series: a dict of arrays over
    the cycles, with t (s), torque (external torque, N m), beyond (external torque without the torque of the load, N m), band
    (the limit of beyond without contact), contact, mass (kg). page: HTML. text: what the program prints.

    >>> rist.replay("arm.urdf", estimate, "log.csv")["contacts"]

    Options:
    - reference: Logs without contact, from which the noise of the observer is measured [default: the logs of the
      estimate]
    - alarms: Accepted number of false alarms per hour [default: 1.0]
    - observer_gain: Gain of the observer of external torques, 1/s [default: 50.0]
    - order: Filter of the observer of external torques [default: 'first']
    - load_on: Link or frame that carries a load [default: the last link]
    - largest_load: Largest possible mass of a load, kg [default: 10.0]
    - wrench_on: Link or frame for the force and the moment of each contact: both are computed at the origin and
      in the axes of this frame
    - anyway: Use the estimate even if its verdict is no. Otherwise the estimate is refused [default: False]"""
class Monitor:
    """Observer of the external torque, load and drift of friction, for one sample at a time."""

    def __init__(
        self,
        model: Model | Path,
        estimate: Estimate,
        period: float,
        *,
        reference: Sequence[Path] | None = None,
        alarms: float = 1.0,
        observer_gain: float = 50.0,
        order: Literal["first", "second"] = "first",
        load_on: str | None = None,
        largest_load: float = 10.0,
        wrench_on: str | None = None,
        anyway: bool = False,
    ) -> None:
        """Observer of the external torque, load and drift of friction. It takes one sample at a time, as on a robot.

        model, estimate: as for `replay`. period: time between samples, s.

        >>> monitor = rist.Monitor("arm.urdf", estimate, period=0.002)
        >>> for cycle in (monitor.step(t, q, dq, tau) for t, q, dq, tau in robot): ...

        Options:
        - reference: Logs without contact, from which the noise of the observer is measured [default: the logs of the
          estimate]
        - alarms: Accepted number of false alarms per hour [default: 1.0]
        - observer_gain: Gain of the observer of external torques, 1/s [default: 50.0]
        - order: Filter of the observer of external torques [default: 'first']
        - load_on: Link or frame that carries a load [default: the last link]
        - largest_load: Largest possible mass of a load, kg [default: 10.0]
        - wrench_on: Link or frame for the force and the moment of each contact: both are computed at the origin and
          in the axes of this frame
        - anyway: Use the estimate even if its verdict is no. Otherwise the estimate is refused [default: False]"""
    def step(self, t: float, q: ArrayLike, dq: ArrayLike, tau: ArrayLike) -> dict[str, Any] | None:
        """Takes a sample. t: time, s. q, dq, tau: position, velocity and torque of the motor of each coordinate, SI units.

        Returns a dict. t: time, s. torque: the external torque; beyond: the external torque without the torque of the load;
        band: the limit of beyond without contact; these are arrays in N m (N). contact: whether there is contact. last_joint:
        the link of this joint, or a later link, is touched. wrench: force and moment on `wrench_on`, None for a component that
        is not determined. mass: mass of the load, kg; sigma: its standard deviation. parameters: of the load. changes: how
        often the load has changed. candidate: mass and its standard deviation if the present contact is a load, kg; else None.
        Returns None if the sample is not used, because it has NaN or its time does not increase."""
    @property
    def coordinates(self) -> list[str]:
        """Names of the coordinates, in the order of q."""
def calibrate(
    model: Model | Path,
    postures: Path | None = None,
    estimate: Estimate | None = None,
    *,
    what: Literal["zeros", "geometry", "stiffness"] = "geometry",
    gears: Sequence[str] | None = None,
    tip: str | None = None,
    touched: Literal["point", "plane", "sphere"] | None = None,
    names: Literal["dh", "frames"] | None = None,
    design: int | None = None,
    measured: Literal["pose", "point"] = "pose",
    options: Path | Mapping[str, Any] | None = None,
) -> dict[str, Any]:
    """Identifies errors of the geometry, zeros or compliances of a robot from measured poses, points or distances.

    model: a Model or a path; read a URDF with angles="as-given". postures: the path of a table with one posture per row: joint
    positions, and x y z with qx qy qz qw or roll pitch yaw, or points x1 y1 z1 x2 .., or a distance. estimate: for
    what="stiffness", gives the torques that bend the joints.

    Returns a dict with the content of the file of `rist calibrate --out`, and with zeros, the table of the zeros as CSV; urdf,
    the URDF with calibrated origins, None if the model has another format or if scales are fitted; text, what the program
    prints. Without postures, but with design: the postures to measure, and csv, their table.

    >>> rist.calibrate("arm.urdf", "poses.csv")["verdict"]
    >>> rist.calibrate("arm.urdf", design=20)["csv"]

    Options:
    - what: Errors to fit, in addition to the frames of base, tool and markers [default: 'geometry']
    - gears: Joints whose scale (gear ratio) is fitted too
    - tip: The measured link, at the end of the chain [default: the link with most joints before it]
    - touched: What the tool touched at each posture, for a table without measurements
    - names: How the errors of the geometry are named [default: frames for a URDF, dh for other descriptions]
    - design: Number of postures to choose if no table is given. The chosen postures determine the parameters best
    - measured: What will be measured at the postures of design= [default: 'pose']
    - options: YAML with the columns of the table, and with corrections of its numbers"""
def example(directory: Path = "ur5") -> list[PathLike[str]]:
    """Writes a robot description and two logs of the robot into a directory, to try rist: ur5.urdf, log.csv and other.csv. Returns
    their paths. Also writes poses.csv, measured poses for `rist.calibrate`, into the same directory.

    >>> robot, log, other = rist.example()
    >>> rist.identify(robot, log, validate=other)"""
