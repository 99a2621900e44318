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
        """How each follows from the standard parameters, exact in the symbols of the description: "ZZR1 = ZZ1 + IA1 + .."."""
    @property
    def no_effect(self) -> list[str]:
        """Standard parameters without effect on the torques, by name."""
    @property
    def matrix(self) -> Numbers:
        """K, shape (p, p_s): X_base = K X_standard."""
    def __len__(self) -> int: ...
    def __getitem__(self, name: str | int) -> str:
        """The rule of a parameter by its name: base["ZZR1"]; or by its place, as of a list."""
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
        """A robot and what follows from it: base parameters, regressors, torques, source.

        `Model(path)` reads a description (.yaml, .urdf, .xacro, .xml of MuJoCo, .par) and derives its dynamics; `Model.read` is the same. Functions of the state take arrays
        of shape (N, n), one state per row and one column per coordinate, or (n,) for one state: q in rad (m of a joint that slides),
        dq in rad/s, ddq in rad/s^2; absent rates are zero. They release the interpreter lock. float64 arrays row by row are not
        copied.

        >>> model = rist.Model("models/panda.yaml")
        >>> y = model.base_regressor(q, dq, ddq)     # (N, n, p)
        >>> w = y.reshape(-1, y.shape[-1])           # the observation matrix, (N n, p), without a copy

        Options:
        - value: Value of a symbol of the description, m or rad: D3=0.45 (symbols of a .par file may have no value)
        - arg: Value of an argument of a xacro, which `$(arg NAME)` asks for [default: as the file says]
        - package: Folder of a package that a xacro includes from, which `$(find NAME)` asks for, or from which an
          MJCF takes meshes and parts; without it a xacro finds packages with a package.xml above its folder
        - root: The robot where a file has several: a body of the world of an MJCF, or a model of an SDF [default: all
          that is in the file]
        - mimic: How the mimic joints of a URDF are read: as following the joint they mimic, or as coordinates of
          their own [default: 'constraint']
        - angles: How rounded angles are read: as the angles that were meant (1.5707 and 1.5708 as pi/2), or as given
          [default: 'meant']
        - rotor_inertia: Which joints have a rotor inertia (IA) among their parameters [default: as the file says; a
          YAML file that does not say: actuated; a URDF, which cannot say: none]
        - lock: Joints that stand still at a position, rad or m, as a gripper that the log does not have: finger=0.02.
          Without it no joint is locked
        - base: How the base is mounted, rad: roll, pitch and yaw of its frame in one in which gravity is as the file
          says. 3.1416,0,0 is a robot on a ceiling [default: as the file says]
        - floating_base: Let the base float: six coordinates come first (base_x, base_y, base_z, base_yaw, base_pitch,
          base_roll), and the base becomes a link with its own parameters [default: False]
        - any_size: Derive the model even where that takes more than about 10 s or 1 GiB, which is refused with the
          figures otherwise [default: False]"""
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
        """Reads a description (.yaml, .urdf, .xacro, .xml of MuJoCo, .par) and derives its dynamics. Angles that are taken for others are a warning.
        Raises rist.Error with the place of what cannot be read.

        Options:
        - value: Value of a symbol of the description, m or rad: D3=0.45 (symbols of a .par file may have no value)
        - arg: Value of an argument of a xacro, which `$(arg NAME)` asks for [default: as the file says]
        - package: Folder of a package that a xacro includes from, which `$(find NAME)` asks for, or from which an
          MJCF takes meshes and parts; without it a xacro finds packages with a package.xml above its folder
        - root: The robot where a file has several: a body of the world of an MJCF, or a model of an SDF [default: all
          that is in the file]
        - mimic: How the mimic joints of a URDF are read: as following the joint they mimic, or as coordinates of
          their own [default: 'constraint']
        - angles: How rounded angles are read: as the angles that were meant (1.5707 and 1.5708 as pi/2), or as given
          [default: 'meant']
        - rotor_inertia: Which joints have a rotor inertia (IA) among their parameters [default: as the file says; a
          YAML file that does not say: actuated; a URDF, which cannot say: none]
        - lock: Joints that stand still at a position, rad or m, as a gripper that the log does not have: finger=0.02.
          Without it no joint is locked
        - base: How the base is mounted, rad: roll, pitch and yaw of its frame in one in which gravity is as the file
          says. 3.1416,0,0 is a robot on a ceiling [default: as the file says]
        - floating_base: Let the base float: six coordinates come first (base_x, base_y, base_z, base_yaw, base_pitch,
          base_roll), and the base becomes a link with its own parameters [default: False]
        - any_size: Derive the model even where that takes more than about 10 s or 1 GiB, which is refused with the
          figures otherwise [default: False]"""
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
        """Reads a description from a text; `name` ends in .yaml, .urdf or .par, which is its format, and is used in messages.

        Options:
        - value: Value of a symbol of the description, m or rad: D3=0.45 (symbols of a .par file may have no value)
        - arg: Value of an argument of a xacro, which `$(arg NAME)` asks for [default: as the file says]
        - package: Folder of a package that a xacro includes from, which `$(find NAME)` asks for, or from which an
          MJCF takes meshes and parts; without it a xacro finds packages with a package.xml above its folder
        - root: The robot where a file has several: a body of the world of an MJCF, or a model of an SDF [default: all
          that is in the file]
        - mimic: How the mimic joints of a URDF are read: as following the joint they mimic, or as coordinates of
          their own [default: 'constraint']
        - angles: How rounded angles are read: as the angles that were meant (1.5707 and 1.5708 as pi/2), or as given
          [default: 'meant']
        - rotor_inertia: Which joints have a rotor inertia (IA) among their parameters [default: as the file says; a
          YAML file that does not say: actuated; a URDF, which cannot say: none]
        - lock: Joints that stand still at a position, rad or m, as a gripper that the log does not have: finger=0.02.
          Without it no joint is locked
        - base: How the base is mounted, rad: roll, pitch and yaw of its frame in one in which gravity is as the file
          says. 3.1416,0,0 is a robot on a ceiling [default: as the file says]
        - floating_base: Let the base float: six coordinates come first (base_x, base_y, base_z, base_yaw, base_pitch,
          base_roll), and the base becomes a link with its own parameters [default: False]
        - any_size: Derive the model even where that takes more than about 10 s or 1 GiB, which is refused with the
          figures otherwise [default: False]"""
    @property
    def name(self) -> str:
        """The name of the robot."""
    @property
    def path(self) -> PathLike[str]:
        """The file it was read from."""
    @property
    def coordinates(self) -> list[str]:
        """Names of the n coordinates, in the order of the columns of q."""
    @property
    def base_parameters(self) -> BaseParameters:
        """The p base parameters, with names, rules and matrix."""
    @property
    def standard_parameters(self) -> list[str]:
        """Names of the standard parameters, in the order of the columns of `regressor`: XX XY XZ YY YZ ZZ MX MY MZ M of each
        link about its frame (kg m^2, kg m, kg), IA where a joint has a rotor."""
    @property
    def nominal_parameters(self) -> Numbers | None:
        """Nominal base parameters, from the inertials of the description, (p,); None where it has none."""
    @property
    def described_parameters(self) -> Numbers | None:
        """The former name of `nominal_parameters`."""
    @property
    def is_compiled(self) -> bool:
        """Whether the base regressor is compiled into this package; other robots are evaluated by tape."""
    def report(self, path: Path) -> None:
        """Writes the page of `rist inspect`: the robot with its frames, its base parameters, their meanings and rules."""
    def to_dict(self) -> dict[str, Any]:
        """What `rist inspect --format json` prints, as dicts, lists, texts and numbers."""
    def _repr_html_(self) -> str: ...
    def regressor(self, q: ArrayLike, dq: ArrayLike | None = None, ddq: ArrayLike | None = None) -> Numbers:
        """Y(q, dq, ddq) of the standard parameters, tau = Y X: shape (N, n, p_s), N m (N) per unit of the parameter."""
    def base_regressor(self, q: ArrayLike, dq: ArrayLike | None = None, ddq: ArrayLike | None = None) -> Numbers:
        """Y(q, dq, ddq) of the base parameters, tau = Y X: shape (N, n, p), N m (N) per unit of the parameter.

        reshape(-1, p) makes the observation matrix of it without a copy."""
    def torque(
        self,
        q: ArrayLike,
        dq: ArrayLike | None = None,
        ddq: ArrayLike | None = None,
        parameters: ArrayLike | Estimate | None = None,
    ) -> Numbers:
        """The joint torques without friction, shape (N, n), N m (N of a joint that slides).

        parameters: p base or p_s standard ones, or an Estimate; without them those of the description."""
    def inertia_matrix(self, q: ArrayLike, parameters: ArrayLike | Estimate | None = None) -> Numbers:
        """The inertia matrix A(q), shape (N, n, n), kg m^2; parameters as of `torque`."""
    def bias(self, q: ArrayLike, dq: ArrayLike | None = None, parameters: ArrayLike | Estimate | None = None) -> Numbers:
        """Coriolis, centrifugal and gravity torques, shape (N, n), N m (N); parameters as of `torque`."""
    def gravity(self, q: ArrayLike, parameters: ArrayLike | Estimate | None = None) -> Numbers:
        """Gravity torques, shape (N, n), N m (N); parameters as of `torque`."""
    def energy(
        self, q: ArrayLike, dq: ArrayLike | None = None, parameters: ArrayLike | Estimate | None = None
    ) -> Numbers:
        """Kinetic and potential energy, shape (N, 2), J; parameters as of `torque`. With base parameters the potential one is
        determined up to a constant."""
    def forward_dynamics(
        self, q: ArrayLike, dq: ArrayLike | None, tau: ArrayLike, parameters: ArrayLike | Estimate | None = None
    ) -> Numbers:
        """The accelerations that torques give, without friction, shape (N, n), rad/s^2 (m/s^2); parameters as of `torque`."""
    def torque_derivatives(
        self,
        q: ArrayLike,
        dq: ArrayLike | None = None,
        ddq: ArrayLike | None = None,
        parameters: ArrayLike | Estimate | None = None,
    ) -> tuple[Numbers, Numbers]:
        """Derivatives of the torques by q and dq, each (N, n, n), N m per rad and per rad/s; that by ddq is the inertia matrix."""
    def forward_dynamics_derivatives(
        self, q: ArrayLike, dq: ArrayLike | None, tau: ArrayLike, parameters: ArrayLike | Estimate | None = None
    ) -> tuple[Numbers, Numbers, Numbers]:
        """Derivatives of the accelerations by q, dq and tau, each (N, n, n)."""
    def pose(self, link: str, q: ArrayLike, frame: str | None = None) -> Numbers:
        """Orientation and position of a link, (N, 3, 4), in the base frame or in that of another link."""
    def jacobian(self, link: str, q: ArrayLike, frame: str | None = None) -> Numbers:
        """Jacobian of a link, (N, 6, n): velocity of its origin, then angular velocity, in its own axes, or in those of another
        link or of "base"."""
    def evaluate(
        self,
        function: str,
        q: ArrayLike | None = None,
        dq: ArrayLike | None = None,
        ddq: ArrayLike | None = None,
        parameters: ArrayLike | Estimate | None = None,
        **others: ArrayLike,
    ) -> Numbers | dict[str, Numbers]:
        """Any function of `rist generate` by its name ("coriolis-matrix", "velocity=LINK", "inverse-geometry=LINK", ..): its
        output, or a dict of them by name. What it needs beside q, dq, ddq and parameters is given by keyword, a row per
        state: tau=, wrench=, point=, t=, dq_r=, ddq_r=."""
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
        """Why, the weightiest reason first."""
    @property
    def next(self) -> str:
        """What to do now."""
    @property
    def uses(self) -> dict[str, Literal["yes", "with care", "no"]]:
        """The answer for each use, by its name."""
    @property
    def torque_errors(self) -> dict[str, float | None]:
        """How unsure the torque is for each use, relative, by its name; None where that is not known."""
    @property
    def claims(self) -> list[str]:
        """All that was claimed, each with its evidence."""
    def to_dict(self) -> dict[str, Any]:
        """trust, found, reasons, next, uses, torque_errors and claims by their names."""
    def _repr_html_(self) -> str: ...

class Estimate:
    """Identified parameters with their standard deviations, the residuals, and what the data do not determine."""

    @staticmethod
    def read(path: Path, model: Model | Path | None = None) -> Estimate:
        """Reads estimate.yaml; with its model it can predict other logs. Raises rist.Error where it was made with another."""
    @property
    def model(self) -> Model | None:
        """The model it was made with, which may have rotor inertias that a URDF cannot say; None where it was read without."""
    @property
    def validation(self) -> Validation | None:
        """How well it predicts the logs of validate=; None without them."""
    @property
    def notes(self) -> list[str]:
        """What a simulation assumed where the description says nothing, in sentences."""
    def __getitem__(self, name: str | int) -> float | None:
        """A value by its name, estimate["ZZR1"]; None where the data do not tell. KeyError says which name was meant. Or by its
        place, as of a list."""
    def __contains__(self, name: object) -> bool: ...
    def __len__(self) -> int: ...
    def __iter__(self) -> Iterator[str]:
        """The names."""
    def to_dict(self) -> dict[str, Any]:
        """What estimate.yaml holds, as dicts, lists, texts and numbers."""
    def plot(self, log: Logs | None = None) -> Any:
        """Draws measured and identified torques of a log, or of those that it was made from, joint by joint, and the residual;
        of an estimate of experiments its parameters. Axes of matplotlib, or a rist.Picture of the page where that is not there."""
    def _repr_html_(self) -> str: ...
    @property
    def names(self) -> list[str]:
        """Names of the parameters: base parameters, then friction, couplings and drive gains."""
    @property
    def units(self) -> list[str]:
        """SI units, one per parameter."""
    @property
    def parameters(self) -> dict[str, float | None]:
        """Values by name; None where the data do not tell."""
    @property
    def values(self) -> Numbers:
        """Values, not a number where the data do not tell."""
    @property
    def sigma(self) -> Numbers:
        """Standard deviations, in the units of the values: those to believe."""
    @property
    def white_sigma(self) -> Numbers:
        """What the standard deviations would be if the model were exact and the noise white."""
    @property
    def status(self) -> list[str]:
        """What each value is worth: "identified", "not_significant", "weak" or "not_identifiable"."""
    @property
    def table(self) -> dict[str, Any]:
        """A dict of columns (name, value, sigma, white_sigma, unit, status), as pandas.DataFrame and polars.DataFrame take it;
        a value that the data do not tell is not a number there, and null in the Arrow table."""
    def __arrow_c_stream__(self, requested_schema: object | None = None) -> object:
        """The table as an Arrow stream, for pyarrow.table(estimate) and polars.DataFrame(estimate)."""
    @property
    def covariance(self) -> Numbers | None:
        """The covariance of the values, (P, P), for white noise; None unless identify was called with covariance=True."""
    @property
    def remarks(self) -> list[str]:
        """Sentences on what the data cannot tell."""
    @property
    def findings(self) -> list[str]:
        """What the logs have against the description (units, signs, columns), the worst first."""
    @property
    def load(self) -> str | None:
        """The load on the last link, as the program prints it; None without loaded logs."""
    @property
    def verdict(self) -> Verdict:
        """Whether to trust it, and why."""
    @property
    def total(self) -> float | None:
        """|tau - W X| / |tau| over all joints; None where no torques were fitted."""
    @property
    def cross_validation(self) -> float | None:
        """The same on tenths of the log, each predicted from the others; None for estimates of experiments."""
    @property
    def cutoff(self) -> float | None:
        """Cut-off of the low-pass, Hz; None where nothing was filtered."""
    @property
    def condition_number(self) -> float | None:
        """Condition number of the columns scaled to unit norm; None where there was no such matrix."""
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
        """Torques of a log (or of several, a list then) as the estimate predicts them, filtered as it was made: a dict of
        t (N,) in s, measured and predicted (N, n) in N m (N). Rows that do not count, at standstill, are not numbers.
        Without a log: of those that it was made from."""
    def to_yaml(self) -> str:
        """The text of estimate.yaml, that of the program byte for byte."""
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
        """Writes one self-contained HTML page: the verdict, torques and residuals of the log (or of those that it was made from,
        where they are still there), the parameters with their rules and meanings, the plan and the validation where they are
        given."""
    def write_urdf(self, path: Path, anyway: bool = False) -> list[str]:
        """Writes the URDF of the model with the identified bodies, joint damping and friction; needs consistent=True.

        Returns sentences on what a URDF has no place for. Raises rist.Error where the verdict is no, unless anyway=True."""
    def write_mjcf(self, path: Path, anyway: bool = False) -> None:
        """Writes a MuJoCo model with the identified inertials, damping, friction loss and armature; needs consistent=True. A model
        that was read from an MJCF is kept whole."""

class Validation:
    """How well an estimate predicts logs from which it was not made."""

    @staticmethod
    def read(path: Path) -> Validation:
        """Reads the YAML file that `save` writes."""
    @staticmethod
    def from_yaml(text: str) -> Validation:
        """From the text of `to_yaml`."""
    def to_yaml(self) -> str:
        """The text of the file, that of the program byte for byte."""
    def to_dict(self) -> dict[str, Any]:
        """What the file holds, as dicts, lists, texts and numbers."""
    def _repr_html_(self) -> str: ...
    def save(self, path: Path) -> None:
        """Writes the YAML file."""
    def report(self, path: Path, date: str | None = None) -> None:
        """Writes one self-contained HTML page."""
    def plot(self) -> Any:
        """Draws the relative errors by joint and by log. Axes of matplotlib, or a rist.Picture where
        that is not there."""
    @property
    def total(self) -> float:
        """|tau - tau_predicted| / |tau| over all joints and logs."""
    @property
    def joints(self) -> dict[str, list[Any]]:
        """One joint a row: a dict of columns (coordinate, relative, rms, unit)."""
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
        """From the text of `to_yaml`."""
    def to_yaml(self) -> str:
        """The text of the file, that of the program byte for byte."""
    def to_dict(self) -> dict[str, Any]:
        """What the file holds, as dicts, lists, texts and numbers."""
    def _repr_html_(self) -> str: ...
    def save(self, path: Path) -> None:
        """Writes the YAML file."""
    @property
    def names(self) -> list[str]:
        """Names of the experiments: their logs are e01.csv, .."""
    def write_trajectories(
        self, directory: Path, rate: float, format: Literal["csv", "yaml", "json"] = "csv"
    ) -> None:
        """Writes each motion for a controller to play into a directory, sampled at `rate` Hz: "csv", or a JointTrajectory of ROS
        as "yaml" or "json"."""
    def report(self, path: Path, date: str | None = None, model: Model | Path | None = None) -> None:
        """Writes one self-contained HTML page. With its model, or the path of its description, the limits of each experiment and the
        worth of the plan are proved anew; without one the page shows the statements of the file."""

class ExcitingMotion:
    """One motion of all joints that excites the parameters, with the proof that it keeps its limits."""

    @staticmethod
    def read(path: Path) -> ExcitingMotion:
        """Reads the YAML file that `save` writes."""
    @staticmethod
    def from_yaml(text: str) -> ExcitingMotion:
        """From the text of `to_yaml`."""
    def to_yaml(self) -> str:
        """The text of the file, that of the program byte for byte."""
    def to_dict(self) -> dict[str, Any]:
        """What the file holds, as dicts, lists, texts and numbers."""
    def _repr_html_(self) -> str: ...
    def save(self, path: Path) -> None:
        """Writes the YAML file."""
    @property
    def proven(self) -> bool:
        """Whether all that is looked at is proven, between samples too, and all that was asked for is looked at."""
    @property
    def notes(self) -> list[str]:
        """Sentences on what the description does not say and was assumed."""
    @property
    def condition_number(self) -> float:
        """Condition number of the scaled columns that the motion makes visible."""
    def trajectory(self) -> str:
        """Positions to play at `rate_hz`: a text of CSV."""
    def report(self, path: Path, date: str | None = None, model: Model | Path | None = None) -> None:
        """Writes one self-contained HTML page: the motion within its limits, the path of the tip, what it makes visible. A motion
        out of a file is drawn in full with its model, or the path of its description, and its limits are proved anew."""
    def write_play(self, path: Path, unproven: bool = False, model: Model | Path | None = None) -> None:
        """Writes the motion for a controller to play; the end of the name chooses the format: .csv, .yaml or .json (ROS
        JointTrajectory), .script (URScript servoj). Raises rist.Error where its limits are not proven, unless unproven=True."""
    def plot(self) -> Any:
        """Draws positions and velocities over time, with the limits of the positions. Axes of matplotlib, or a rist.Picture of
        the page where that is not there."""

class LogCheck:
    """The result of checking that logs belong to a description."""

    @property
    def findings(self) -> list[str]:
        """What is wrong, the worst first: a sentence each with what mends it."""
    @property
    def not_checked(self) -> list[str]:
        """Checks that were not possible, each with its reason."""
    @property
    def untold(self) -> list[str]:
        """The former name of `not_checked`."""
    @property
    def is_gross(self) -> bool:
        """Whether a finding forbids to use an estimate from these logs."""
    @property
    def joints(self) -> dict[str, list[Any]]:
        """How each joint agrees with the description, a dict of columns: coordinate; slope, measured torque per torque of the
        description; share of the torque that the slope rests on; explained, the share with rotor, friction and offset; range
        of its motion, rad (m)."""
    @property
    def claims(self) -> list[str]:
        """All that was claimed: what is contradicted, what agrees and what fault would have shown, what cannot be determined."""
    def to_dict(self) -> dict[str, Any]:
        """findings, not_checked, is_gross, joints and claims by their names."""
    def plot(self) -> Any:
        """Draws the slope of each joint, which is 1 where log and description agree. Axes of matplotlib, or a rist.Picture where
        that is not there."""
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
        """Sums over logs of one robot: `update` with a log where it lies, `merge` with those of others, `solve` without the logs.

        All parts of one sum need one cut-off (Hz) and the same options: cutoff, order, decimate, delay, friction, weights
        ("none", "joint"), gain ({"q1": 2.393}, N m/A), options, as of `identify`. An accumulator pickles to some kilobytes, so
        workers of any engine can make them; merged in any order they are one pass, to rounding.

        >>> sums = rist.Accumulator(model, cutoff=10.0)
        >>> sums.update("monday.mcap").merge(other)
        >>> estimate = sums.solve()

        Options:
        - gain: Torque per unit of current of every drive, N m/A [default: as the description says]
        - friction: Friction columns per joint: viscous, coulomb, offset, asymmetric, load, rotor, smooth-coulomb=V,
          stribeck=V (V in rad/s), none, or auto, the set that best predicts parts of the logs left out of the fit
          [default: viscous,coulomb,offset]
        - weights: What rows weigh [default: joint]
        - cutoff: Cut-off of the zero-phase low-pass, Hz [default: by the frequency content of the logs]
        - order: Order of the Butterworth filter, 0 for none [default: 4]
        - rate: Rows per second, of a log without a clock
        - decimate: Keep every N-th filtered sample [default: by the cut-off]
        - delay: Seconds by which the torques lag the positions, negative where they come before [default: 0]; or
          auto: the delay, up to a quarter of a second to both sides, with the smallest residual on rows away from
          reversals of their joint. The residual of all rows may be larger with it than without
        - options: YAML with any option of an identification; other options override it"""
    def update(self, log: Logs, anyway: bool = False) -> Accumulator:
        """Adds a log, or a list of them, as `identify` takes them; returns itself.

        Raises rist.Error, and adds nothing of that log, where it cannot be used, is in the sums already, or does not belong
        to the model (anyway=True takes it in)."""
    def merge(self, other: Accumulator) -> Accumulator:
        """Adds the logs of another; returns itself. Raises rist.Error with what differs, and where a log is in both."""
    def fail(self, log: str, reason: str) -> None:
        """Notes a log that could not be used, so that every estimate of the sums says it."""
    def solve(self) -> Estimate:
        """The estimate of all logs."""
    @property
    def logs(self) -> list[str]:
        """Names of the logs in the sums."""
    @property
    def samples(self) -> int:
        """Samples in the sums, after the filter."""
    @property
    def failed(self) -> list[tuple[str, str]]:
        """Logs that could not be used, each with the reason."""
    def to_bytes(self) -> bytes:
        """The content of the .tri file of the program."""
    def save(self, path: Path) -> None:
        """Writes the .tri file of the program."""
    @staticmethod
    def read(path: Path, model: Model | Path) -> Accumulator:
        """Reads a .tri file. Raises rist.Error where it is none, was cut short, or is of another model."""
    def __len__(self) -> int: ...

class Comparison:
    """What changed between sums."""

    @staticmethod
    def read(path: Path) -> Comparison:
        """Reads the YAML file that `save` writes."""
    @staticmethod
    def from_yaml(text: str) -> Comparison:
        """From the text of `to_yaml`."""
    def to_yaml(self) -> str:
        """The text of the file, that of the program byte for byte."""
    def to_dict(self) -> dict[str, Any]:
        """What the file holds, as dicts, lists, texts and numbers."""
    def _repr_html_(self) -> str: ...
    def save(self, path: Path) -> None:
        """Writes the YAML file."""
    @property
    def changed(self) -> list[str]:
        """Names of those that changed."""
    @property
    def moved(self) -> dict[str, dict[str, tuple[float, float]]]:
        """Parameters that moved, by name of the robot: dicts of name -> (difference, sigma), in the unit of the parameter."""

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
    """Identifies the base parameters and the friction of a robot from logs of it. rist.TrustWarning where the verdict says no.

    model: a Model, or the path of a description. logs: one or a list; each a path (CSV, .npz, Arrow, Parquet, MCAP, a rosbag2 directory), a dict of arrays ({"t": (N,),
    "q": (N, n), "tau": (N, n)}; SI), or a table with __arrow_c_stream__ (pandas, polars, pyarrow). With method="rist",
    "rist-mh", "iv" or "didim": the directory of the logs of `plan`.

    Options:
    - consistent: Physically consistent parameters: only bodies that can exist. Where the log says nothing, they
      stay near the bodies of the description [default: False]
    - free_bodies: Leave the bodies free where a log is poor, in place of those that can exist where they predict
      it better [default: False]
    - gain: Torque per unit of current of a drive, N m/A [default: as the file says]. Where only some drives are
      given, the others are estimated; q5=11+-2 expects a gain near 11
    - arm: A hobby arm or its servo, whose units, zeros and gains are taken where nothing else gives them: so101,
      koch, wx250s, vx300s, openmanipulator-x, xm430-w350, ..; with the form of the positions as so101:degrees,
      :normalised, :counts or :radians
    - unknowns: What is unknown beside the parameters, of all joints: mount, zeros, scales, springs. The estimate
      says each with its deviation, and the option or line of the URDF that mends it
    - leave_out_contact: Leave out the rows in which the residual is an outlier, such as a contact. The estimate
      names them [default: False]
    - covariance: Keep the covariance of the parameters in the estimate [default: False]
    - loaded_link: The link that carries the load of the logs with a load [default: the last]
    - friction: Friction columns per joint: viscous, coulomb, offset, asymmetric, load, rotor, smooth-coulomb=V,
      stribeck=V (V in rad/s), none, or auto, the set that best predicts parts of the logs left out of the fit
      [default: viscous,coulomb,offset]
    - weights: What rows weigh [default: joint]
    - cutoff: Cut-off of the zero-phase low-pass, Hz [default: by the frequency content of the logs]
    - order: Order of the Butterworth filter, 0 for none [default: 4]
    - rate: Rows per second, of a log without a clock
    - decimate: Keep every N-th filtered sample [default: by the cut-off]
    - delay: Seconds by which the torques lag the positions, negative where they come before [default: 0]; or
      auto: the delay, up to a quarter of a second to both sides, with the smallest residual on rows away from
      reversals of their joint. The residual of all rows may be larger with it than without
    - options: YAML with any option of an identification; other options override it
    - load: A known load: YAML with link, mass (kg), centre_of_mass (m) and inertia about it (kg m^2). The logs of
      the experiments repeated with it, e01_loaded.csv, .., stand beside the others; no gain need be known
    - ripple: Estimate ripple of torque and gain with so many periods a turn, of a coordinate or of all
    - spring: Estimate a spring beside the motor of these coordinates, or of all, as one that balances gravity
      [default: False]
    - eccentric: Estimate by how much the encoders of these coordinates, or of all, are off once a turn [default:
      False]
    - elastic: Estimate the springs of these coordinates, or of all; the encoders are at the motors. The equations
      end at 10 Hz then, unless cutoff= says otherwise [default: False]
    - backlash: Estimate the backlash of these joints, or of all, as elastic= does springs [default: False]
    - method: The equations to solve; all but ls and essential need the plan behind the logs [default: 'ls']
    - loaded: Logs with a load on the last link, which is identified too
    - validate: Logs that are predicted, not fitted, for the verdict
    - plan: The plan behind the logs
    - rotor_inertia: Which joints have a rotor inertia (IA) among their parameters [default: as the file says; a
      YAML file that does not say: actuated; a URDF, which cannot say: none]

    With method="rist-mh" it also estimates, where asked: ripple (periods a turn of all joints, or {"q2": 12}, or
    {"q2": [6, 12]}), elastic and backlash (True for all joints, or ["q2", "q3"]: springs and gaps behind the motors, which have
    the encoders; the equations end at 10 Hz then, unless cutoff says otherwise), delay="auto". cutoff: highest frequency of
    the equations (20 Hz).

    Ctrl-C ends it. Raises rist.Error with the message of the program."""
def validate(
    model: Model | Path,
    estimate: Estimate,
    logs: Logs,
    *,
    gain: Mapping[str, float] | None = None,
    cutoff: float | None = None,
) -> tuple[Validation, Verdict]:
    """Predicts logs with an estimate and compares: a Validation and a Verdict. rist.TrustWarning where that says no.

    model: the one of the estimate, a path too. logs as of `identify`. For an estimate of experiments, logs are the paths of motions, and gain={"q1": 2.4} (N m/A) and
    cutoff (Hz, 20) can be given.

    Options:
    - gain: Torque per unit of current of a drive, N m/A [default: that of the estimate, that of the file, or 1]
    - cutoff: Cut-off of the low-pass on position and torque, Hz [default: 20, or that of the estimate]"""
def doctor(
    model: Model | Path,
    logs: Logs,
    *,
    options: Path | Mapping[str, Any] | None = None,
    gain: Mapping[str, float] | None = None,
    arm: str | None = None,
    rate: float | None = None,
) -> LogCheck:
    """Looks for what is wrong with logs before anything is fitted: units, signs, zeros, swapped columns, another robot.

    model and logs as of `identify`; options: a path to YAML with any option of an identification, its text, or its content as a
    dict; gain: {"q1": 2.393}, N m/A.

    Options:
    - options: YAML with any option of an identification
    - gain: Torque per unit of current of a drive, N m/A; below 0 where the current counts the other way [default:
      as the file says]
    - arm: A hobby arm or its servo, whose units, zeros and gains are taken where nothing else gives them: so101,
      koch, wx250s, vx300s, openmanipulator-x, xm430-w350, ..; with the form of the positions as so101:degrees,
      :normalised, :counts or :radians
    - rate: Rows per second, of a log without a clock"""
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
    """Chooses the experiments that identify a robot best by spectrum analysis. What was assumed where the description says
    nothing is one warning.

    model: a Model, or the path of a description.

    Options:
    - experiments: Number of experiments [default: 8]
    - criterion: What the plan makes best [default: 'determinant']
    - profile: Acceleration within a swing [default: 'bang-bang']
    - steps: Configurations of the grid per coordinate [default: 5]
    - configurations: Maximum number of configurations per kind of motion [default: 60]
    - limits: YAML with tighter limits, and with the room of the bodies, as for `rist excite`
    - effort_share: Share of the limits of effort that the torque of the description may use [default: 0.9]
    - duration: Seconds recorded in one experiment [default: 4.0]
    - rate: Sample rate of the controller, Hz [default: 1000.0]
    - starts: Starts of the search [default: 12]
    - seed: Seed of the random starts; the same seed gives the same plan [default: 1]
    - nodes: Maximum number of nodes of a branch and bound, 0 for none. It improves the plan and proves how far
      from the best it can be. It ends where the D-efficiency is within 0.001 of the best. The proof is written
      into the plan [default: 0]
    - progress: Called with (done, all, text) as work goes on"""
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
    """Simulates the experiments of a plan, or an ExcitingMotion, in closed loop, with friction, noise and drive gains. What it
    assumes where the description says nothing stands in `.notes` of the estimate that it returns.

    model: a Model, or the path of a description. plan: a plan or a motion, or the path of one.

    With out="DIRECTORY" it writes a log an experiment (e01.csv, .. or motion.csv, v01.csv, .. of motions for validation, e01_loaded.csv,
    ..), truth.yaml, and truth_loaded.yaml with a load, as `rist simulate` does. Returns the parameters behind the logs, an
    Estimate, and the logs: a dict by name of dicts of arrays t (N,) in s, q (N, n) in rad (m), i (N, n) in A, which
    `identify` takes.

    Options:
    - validation: Number of validation motions [default: 10]
    - gain: Torque per unit of current of a drive, N m/A [default: as the file says; where one is known, 1 for the
      others]
    - load: A known load (as of `rist identify`): every experiment is done again with it, e01_loaded.csv, ..
    - feedforward: Of which the controller computes its torques
    - seed: Seed of the noise; the same seed gives the same logs [default: 1]
    - noise_free: Neither noise nor rounding of the sensors [default: False]
    - out: The directory that the logs are written to
    - progress: Called with (done, all, text) as work goes on"""
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
    """Searches one motion of all joints that makes the parameters visible, and proves that it keeps its limits. A motion that
    is not proven says so: look at `.proven` before it is played.

    model: a Model, or the path of a description.

    Options:
    - motion: The form of the motion [default: 'fourier']
    - period: Seconds of a period, of a spline from rest to rest [default: by the limits, 5 to 20]
    - frequency: Base frequency, Hz: one over the period
    - harmonics: Harmonics of the base frequency [default: by the limits and the period, 5 to 8; 5 of more than 8
      joints]
    - spans: Spans of a spline: the more, the freer, and the longer the search [default: by the limits, 8 to 30]
    - repetitions: Whole periods between the blends; times that a spline is played [default: 3]
    - blend: Seconds from rest to the series, and back to rest [default: by the limits]
    - rate: Sample rate of the file to play and of the log, Hz [default: 200.0]
    - limits: YAML with tighter limits: `coordinates: {NAME: {position: [LOW, HIGH], velocity, acceleration, jerk,
      effort, power, locked: POSITION, slowed: FACTOR}}`; `all:` has them for every coordinate; `space:` has the
      room of the bodies in the base frame, m: `{floor: Z or none, walls: [{point, normal, links}], boxes: [{low,
      high, links}], distance: 0.01, own_links: true, accept: [[LINK, LINK, REASON]]}`; `margins:` has the errors
      that the proof has room for: `{encoder_zero, tracking, calibration, mesh, payload: {link, mass,
      centre_of_mass}}`
    - effort_share: Share of the limits of effort and power that the torque of the description may use [default:
      0.9]
    - friction: Friction columns a joint that the identification will have, as of `rist identify`, or none
    - criterion: What the motion makes best [default: 'determinant']
    - noise: Noise of a torque sample, as a share of the effort limit [default: 0.01]
    - starts: Starts of the search: a third are random, the others begin near the best so far [default: 12]
    - iterations: Maximum number of iterations of a start at each weight of the barrier [default: 100]
    - seed: Seed of the random starts; the same seed gives the same motion [default: 1]
    - after: The motion shows what this estimate leaves open
    - progress: Called with (done, all, text) as work goes on"""
def check(
    model: Model | Path,
    motion: ExcitingMotion | Path,
    *,
    limits: Path | Mapping[str, Any] | None = None,
    after: Estimate | None = None,
    interpolation: Literal["linear", "cubic", "quintic"] | None = None,
) -> list[str]:
    """Proves anew that a motion keeps its limits, and those of `limits`, a path to YAML or its content as a dict, too; torques
    are those of the description, or of the estimate `after`. Of a plan each experiment is proved so, and what its proof is worth is
    found again. Returns what speaks against it: nothing where all that is looked at is proven, and where all that `limits` asks
    for is looked at.

    model: a Model, or the path of a description. motion: an ExcitingMotion, an ExperimentPlan, or the path of one, of a table
    of points (CSV) or of a JointTrajectory (YAML, JSON).

    Options:
    - limits: Limits of your own that the motion must keep too, as for `rist excite limits=`; those that the file
      lacks are not assumed. What a motion may leave out, `space: {floor: none, accept: ..}`, counts in this file
      alone
    - after: Efforts and powers are proved with its torques instead of the description's
    - interpolation: How a controller goes between the points of a table or a JointTrajectory [default: the
      smoothest that the points allow]"""
def compare(
    reference: Accumulator,
    robots: Mapping[str,
    Accumulator],
    *,
    of: Literal["all", "inertial"] = "all",
    fdr: float = 0.05,
) -> Comparison:
    """Compares sums with those of a reference: robots by name, {"r07": Accumulator, ..}.

    Options:
    - of: The parameters that are asked about [default: 'all']
    - fdr: False discovery rate: the expected share of unchanged robots among those reported as changed, and of
      unchanged parameters among those reported [default: 0.05]"""
def wrench(
    log: Log,
    *,
    options: Path | Mapping[str, Any] | None = None,
    link: str = "tool0",
) -> dict[str, Any]:
    """The load behind a force-torque sensor, from a log of it: forces and torques in the axes of the sensor, and its poses in a
    frame at rest whose z points up.

    log: a path (CSV, .npz, Arrow, Parquet, MCAP, a rosbag2 directory), a dict of arrays, or a table with __arrow_c_stream__ (pandas,
    polars, pyarrow). Columns are found by their names: fx fy fz tx ty tz, x y z, qx qy qz qw or roll pitch yaw. Without a clock
    each row is a posture at rest. options: a path to YAML, its text, or its content as a dict.

    Returns a dict: parameters, in and about the frame of the sensor; body, the mass, the centre of mass and the inertia about
    it, None where the log does not tell a body that can exist; offsets; is_reaction, whether the sensor gives what the load does
    to it; residuals, N and N m; rows, left_out; verdict, with trust, reasons, next and claims; and text, what the program prints.
    body is None too where trust is "no".

    >>> rist.wrench("log.csv")["body"]

    Options:
    - options: YAML with the columns of the log, and with corrections of its numbers
    - link: Name of the link whose frame is the sensor's, for the file of a load [default: 'tool0']"""
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
    """Contact, loads and drift of friction in a log, cycle by cycle, as a robot would find them.

    model: the one of the estimate, a path too. log as of `identify`. The estimate should hold its covariance.

    Returns a dict: contacts, loads and joints, lists of dicts; threshold, in standard deviations; series, a dict of arrays over
    the cycles: t (s), torque and beyond (external torque with and without that of the load, N m), band (the limit of beyond
    without contact), contact, mass (kg); page, HTML; and text, what the program prints.

    >>> rist.replay("arm.urdf", estimate, "log.csv")["contacts"]

    Options:
    - reference: Logs without contact, in which the noise of the observer is measured [default: the logs of the
      estimate]
    - alarms: False alarms an hour that are accepted [default: 1.0]
    - observer_gain: Gain of the observer, 1/s [default: 50.0]
    - order: Filter of the observer [default: 'first']
    - load_on: Link or frame that carries a load [default: the last link]
    - largest_load: Largest mass of a load, kg [default: 10.0]
    - wrench_on: Link or frame on which the force and the moment of each contact are computed, at its origin and
      in its axes
    - anyway: Take the numbers even of an estimate whose verdict is no [default: False]"""
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
        """Observer of the external torque, load and drift, a sample at a time, as a robot runs them.

        model, estimate: as of `replay`. period: time between samples, s.

        >>> monitor = rist.Monitor("arm.urdf", estimate, period=0.002)
        >>> for cycle in (monitor.step(t, q, dq, tau) for t, q, dq, tau in robot): ...

        Options:
        - reference: Logs without contact, in which the noise of the observer is measured [default: the logs of the
          estimate]
        - alarms: False alarms an hour that are accepted [default: 1.0]
        - observer_gain: Gain of the observer, 1/s [default: 50.0]
        - order: Filter of the observer [default: 'first']
        - load_on: Link or frame that carries a load [default: the last link]
        - largest_load: Largest mass of a load, kg [default: 10.0]
        - wrench_on: Link or frame on which the force and the moment of each contact are computed, at its origin and
          in its axes
        - anyway: Take the numbers even of an estimate whose verdict is no [default: False]"""
    def step(self, t: float, q: ArrayLike, dq: ArrayLike, tau: ArrayLike) -> dict[str, Any] | None:
        """Takes a sample. t: s; q, dq, tau: position, velocity and torque of the motor of each coordinate, SI units.

        Returns a dict: t; torque and beyond, the external torque with and without that of the load, and band, the limit of beyond
        without contact, arrays in N m (N); contact; last_joint, whose link or a later one is touched; wrench, the force and moment on
        `wrench_on`, None for a component that is not determined; mass (kg); sigma, of the mass; parameters of the load; changes, how
        often the load has changed. None if the sample is not used: NaN, or a time that does not increase."""
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
    """Errors of the geometry, zeros or compliances of a robot, from measured poses, points or distances.

    model: a Model or a path; read a URDF with angles="as-given". postures: a path of a table, one row a posture: joint positions, and
    x y z with qx qy qz qw or roll pitch yaw, or points x1 y1 z1 x2 .., or a distance. estimate: gives the torques that bend the
    joints, for what="stiffness".

    Returns a dict: what `rist calibrate --out` writes; zeros, the table of the zeros as CSV; urdf, the URDF with calibrated origins,
    None where the model is of another format or scales are fitted; and text, what the program prints. Without postures, but with
    design: the postures to measure, with csv, their table.

    >>> rist.calibrate("arm.urdf", "poses.csv")["verdict"]
    >>> rist.calibrate("arm.urdf", design=20)["csv"]

    Options:
    - what: What is fitted besides base, tool and markers [default: 'geometry']
    - gears: Joints whose scales (gear ratios) are fitted too
    - tip: Link that is measured: the end of the chain. By default the link with most joints before it
    - touched: What the tool touched at each posture, for a table without measurements
    - names: How errors of the geometry are named: by default frames for a URDF and dh for others
    - design: Number of postures to choose where no table is given: those that determine the parameters best
    - measured: What will be measured at these postures [default: 'pose']
    - options: YAML with the columns of the table, and with corrections of its numbers"""
def example(directory: Path = "ur5") -> list[PathLike[str]]:
    """Writes a robot description and two logs of the robot into a directory, to try rist: ur5.urdf, log.csv and other.csv. Returns
    their paths.

    >>> robot, log, other = rist.example()
    >>> rist.identify(robot, log, validate=other)"""
