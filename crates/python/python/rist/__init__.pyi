"""From a robot description to an exact symbolic model, generated code, and inertial parameters identified on the machine."""

from os import PathLike
from typing import Any, Callable, Literal, Mapping, Protocol, Sequence, TypeAlias, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

__version__: str

Numbers: TypeAlias = NDArray[np.float64]
Path: TypeAlias = str | PathLike[str]
Progress: TypeAlias = Callable[[int, int, str], object]

class Frame(Protocol):
    """What pandas, polars and pyarrow have."""

    def __arrow_c_stream__(self, requested_schema: object | None = None) -> object: ...

Log: TypeAlias = Path | Mapping[str, Any] | Frame
Logs: TypeAlias = Log | Sequence[Log]

class Error(ValueError):
    """Input that cannot be used, or data that speak against what was asked."""

class BaseParameters:
    """The least set of parameters on which the torques depend."""

    @property
    def names(self) -> list[str]: ...
    @property
    def units(self) -> list[str]: ...
    @property
    def rules(self) -> list[str]: ...
    @property
    def no_effect(self) -> list[str]: ...
    @property
    def matrix(self) -> Numbers:
        """K, (p, p_s): X_base = K X_standard."""
    def __len__(self) -> int: ...

class Model:
    """A robot and what follows from it; functions of the state take (N, n) or (n,) arrays: rad (m), rad/s, rad/s^2."""

    @staticmethod
    def read(
        path: Path,
        *,
        value: Mapping[str, float] | None = None,
        mimic: Literal["constraint", "independent"] = "constraint",
        angles: Literal["meant", "as-given"] = "meant",
        rotor_inertia: Literal["none", "actuated", "all"] | None = None,
        floating_base: bool = False,
        any_size: bool = False,
    ) -> Model:
        """Reads a description (.yaml, .urdf, .par) and derives its dynamics. Angles that are taken for others are a warning.
        Raises rist.Error with the place of what cannot be read.

        Options:
        - value: Value of a symbol of the description, m or rad: D3=0.45 (symbols of a .par file may have no value)
        - mimic: How the mimic joints of a URDF are read: as following the joint they mimic, or as coordinates of
          their own [default: 'constraint']
        - angles: How rounded angles are read: as the angles that were meant (1.5707 and 1.5708 as pi/2), or as given
          [default: 'meant']
        - rotor_inertia: Which joints have a rotor inertia (IA) among their parameters [default: as the file says; a
          YAML file that does not say: actuated; a URDF, which cannot say: none]
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
        mimic: Literal["constraint", "independent"] = "constraint",
        angles: Literal["meant", "as-given"] = "meant",
        rotor_inertia: Literal["none", "actuated", "all"] | None = None,
        floating_base: bool = False,
        any_size: bool = False,
    ) -> Model:
        """The same of a text; `name` ends in .yaml, .urdf or .par, which tells its format, and stands in messages.

        Options:
        - value: Value of a symbol of the description, m or rad: D3=0.45 (symbols of a .par file may have no value)
        - mimic: How the mimic joints of a URDF are read: as following the joint they mimic, or as coordinates of
          their own [default: 'constraint']
        - angles: How rounded angles are read: as the angles that were meant (1.5707 and 1.5708 as pi/2), or as given
          [default: 'meant']
        - rotor_inertia: Which joints have a rotor inertia (IA) among their parameters [default: as the file says; a
          YAML file that does not say: actuated; a URDF, which cannot say: none]
        - floating_base: Let the base float: six coordinates come first (base_x, base_y, base_z, base_yaw, base_pitch,
          base_roll), and the base becomes a link with its own parameters [default: False]
        - any_size: Derive the model even where that takes more than about 10 s or 1 GiB, which is refused with the
          figures otherwise [default: False]"""
    @property
    def name(self) -> str: ...
    @property
    def path(self) -> PathLike[str]: ...
    @property
    def coordinates(self) -> list[str]: ...
    @property
    def base_parameters(self) -> BaseParameters: ...
    @property
    def standard_parameters(self) -> list[str]: ...
    @property
    def described_parameters(self) -> Numbers | None: ...
    @property
    def is_compiled(self) -> bool: ...
    def regressor(self, q: ArrayLike, dq: ArrayLike | None = None, ddq: ArrayLike | None = None) -> Numbers:
        """(N, n, p_s), N m (N) per unit of each standard parameter."""
    def base_regressor(self, q: ArrayLike, dq: ArrayLike | None = None, ddq: ArrayLike | None = None) -> Numbers:
        """(N, n, p), N m (N) per unit of each base parameter."""
    def torque(
        self,
        q: ArrayLike,
        dq: ArrayLike | None = None,
        ddq: ArrayLike | None = None,
        parameters: ArrayLike | Estimate | None = None,
    ) -> Numbers:
        """(N, n), N m (N)."""
    def inertia_matrix(self, q: ArrayLike, parameters: ArrayLike | Estimate | None = None) -> Numbers:
        """(N, n, n), kg m^2."""
    def bias(self, q: ArrayLike, dq: ArrayLike | None = None, parameters: ArrayLike | Estimate | None = None) -> Numbers:
        """(N, n), N m (N)."""
    def gravity(self, q: ArrayLike, parameters: ArrayLike | Estimate | None = None) -> Numbers:
        """(N, n), N m (N)."""
    def energy(
        self, q: ArrayLike, dq: ArrayLike | None = None, parameters: ArrayLike | Estimate | None = None
    ) -> Numbers:
        """(N, 2), J: kinetic and potential energy, of base parameters the potential one up to a constant."""
    def forward_dynamics(
        self, q: ArrayLike, dq: ArrayLike | None, tau: ArrayLike, parameters: ArrayLike | Estimate | None = None
    ) -> Numbers:
        """(N, n), rad/s^2 (m/s^2)."""
    def torque_derivatives(
        self,
        q: ArrayLike,
        dq: ArrayLike | None = None,
        ddq: ArrayLike | None = None,
        parameters: ArrayLike | Estimate | None = None,
    ) -> tuple[Numbers, Numbers]:
        """By q and dq, each (N, n, n)."""
    def forward_dynamics_derivatives(
        self, q: ArrayLike, dq: ArrayLike | None, tau: ArrayLike, parameters: ArrayLike | Estimate | None = None
    ) -> tuple[Numbers, Numbers, Numbers]:
        """By q, dq and tau, each (N, n, n)."""
    def pose(self, link: str, q: ArrayLike, frame: str | None = None) -> Numbers:
        """(N, 3, 4): orientation and position of a link in the base frame, or in that of another link."""
    def jacobian(self, link: str, q: ArrayLike, frame: str | None = None) -> Numbers:
        """(N, 6, n): velocity of a link's origin, then angular velocity, in its axes, or in those of another link or "base"."""
    def evaluate(
        self,
        function: str,
        q: ArrayLike | None = None,
        dq: ArrayLike | None = None,
        ddq: ArrayLike | None = None,
        parameters: ArrayLike | Estimate | None = None,
        **others: ArrayLike,
    ) -> Numbers | dict[str, Numbers]:
        """Any function of `rist generate` by its name: its output, or a dict of them by name."""
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
    def trust(self) -> Literal["yes", "with care", "no"]: ...
    @property
    def found(self) -> str: ...
    @property
    def reasons(self) -> list[str]: ...
    @property
    def next(self) -> str: ...
    @property
    def uses(self) -> dict[str, Literal["yes", "with care", "no"]]: ...
    @property
    def torque_errors(self) -> dict[str, float | None]: ...
    @property
    def claims(self) -> list[str]: ...

class Estimate:
    """Identified parameters with their deviations, the residuals they leave, and what the data cannot tell."""

    @staticmethod
    def read(path: Path, model: Model | None = None) -> Estimate: ...
    @property
    def names(self) -> list[str]: ...
    @property
    def units(self) -> list[str]: ...
    @property
    def parameters(self) -> dict[str, float | None]: ...
    @property
    def values(self) -> Numbers: ...
    @property
    def sigma(self) -> Numbers: ...
    @property
    def white_sigma(self) -> Numbers: ...
    @property
    def status(self) -> list[str]: ...
    @property
    def table(self) -> dict[str, Any]: ...
    def __arrow_c_stream__(self, requested_schema: object | None = None) -> object: ...
    @property
    def covariance(self) -> Numbers | None: ...
    @property
    def remarks(self) -> list[str]: ...
    @property
    def findings(self) -> list[str]: ...
    @property
    def load(self) -> str | None: ...
    @property
    def verdict(self) -> Verdict: ...
    @property
    def total(self) -> float | None: ...
    @property
    def cross_validation(self) -> float | None: ...
    @property
    def cutoff(self) -> float | None: ...
    @property
    def condition_number(self) -> float | None: ...
    @property
    def rank(self) -> int: ...
    @property
    def rows(self) -> int: ...
    @property
    def joints(self) -> dict[str, list[Any]]: ...
    def predict(self, log: Logs) -> Any:
        """A dict of t (N,), measured and predicted (N, n); a list of them for a list of logs."""
    def to_yaml(self) -> str: ...
    def save(self, path: Path) -> None: ...
    def report(
        self,
        path: Path,
        plan: ExperimentPlan | None = None,
        validation: Validation | None = None,
        date: str | None = None,
    ) -> None: ...
    def write_urdf(self, path: Path, anyway: bool = False) -> list[str]: ...
    def write_mjcf(self, path: Path, anyway: bool = False) -> None: ...

class Validation:
    """How well an estimate predicts logs it was not made from."""

    @staticmethod
    def read(path: Path) -> Validation: ...
    @staticmethod
    def from_yaml(text: str) -> Validation: ...
    def to_yaml(self) -> str: ...
    def save(self, path: Path) -> None: ...
    @property
    def total(self) -> float: ...
    @property
    def joints(self) -> dict[str, list[Any]]: ...
    @property
    def logs(self) -> dict[str, float]: ...

class ExperimentPlan:
    """Experiments to run for identification by spectrum analysis, with what they promise."""

    @staticmethod
    def read(path: Path) -> ExperimentPlan: ...
    @staticmethod
    def from_yaml(text: str) -> ExperimentPlan: ...
    def to_yaml(self) -> str: ...
    def save(self, path: Path) -> None: ...
    @property
    def names(self) -> list[str]: ...
    def write_trajectories(self, directory: Path, rate: float) -> None: ...

class ExcitingMotion:
    """One motion of all joints that makes the parameters visible, with the proof that it keeps its limits."""

    @staticmethod
    def read(path: Path) -> ExcitingMotion: ...
    @staticmethod
    def from_yaml(text: str) -> ExcitingMotion: ...
    def to_yaml(self) -> str: ...
    def save(self, path: Path) -> None: ...
    @property
    def proven(self) -> bool: ...
    @property
    def notes(self) -> list[str]: ...
    @property
    def condition_number(self) -> float: ...
    def trajectory(self) -> str: ...

class Passport:
    """What logs and a description have to do with each other."""

    @property
    def findings(self) -> list[str]: ...
    @property
    def untold(self) -> list[str]: ...
    @property
    def is_gross(self) -> bool: ...

class Accumulator:
    """Sums over logs of one robot."""

    def __init__(
        self,
        model: Model,
        *,
        gain: Mapping[str, float] | None = None,
        friction: str | Sequence[str] | None = None,
        weights: Literal["none", "joint", "huber", "bisquare"] | None = None,
        cutoff: float | None = None,
        order: int | None = None,
        decimate: int | None = None,
        delay: float | Literal["auto"] | None = None,
        options: Path | Mapping[str, Any] | None | None = None,
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
        - decimate: Keep every N-th filtered sample [default: by the cut-off]
        - delay: Seconds by which the torques lag the positions, negative where they come before [default: 0]; or
          auto: the delay, up to a quarter of a second to both sides, with the smallest residual on rows away from
          reversals of their joint. The residual of all rows may be larger with it than without
        - options: YAML with any option of an identification; other options override it"""
    def update(self, log: Logs, anyway: bool = False) -> Accumulator: ...
    def merge(self, other: Accumulator) -> Accumulator: ...
    def fail(self, log: str, reason: str) -> None: ...
    def solve(self) -> Estimate: ...
    @property
    def logs(self) -> list[str]: ...
    @property
    def samples(self) -> int: ...
    @property
    def failed(self) -> list[tuple[str, str]]: ...
    def to_bytes(self) -> bytes: ...
    def save(self, path: Path) -> None: ...
    @staticmethod
    def read(path: Path, model: Model) -> Accumulator: ...
    def __len__(self) -> int: ...

class Comparison:
    """What changed between sums."""

    @staticmethod
    def read(path: Path) -> Comparison: ...
    @staticmethod
    def from_yaml(text: str) -> Comparison: ...
    def to_yaml(self) -> str: ...
    def save(self, path: Path) -> None: ...
    @property
    def changed(self) -> list[str]: ...
    @property
    def moved(self) -> dict[str, dict[str, tuple[float, float]]]: ...

def identify(
    model: Model,
    logs: Logs,
    *,
    consistent: bool = False,
    gain: Mapping[str, float | tuple[float, float]] | None = None,
    covariance: bool = False,
    loaded_link: str | None = None,
    friction: str | Sequence[str] | None = None,
    weights: Literal["none", "joint", "huber", "bisquare"] | None = None,
    cutoff: float | None = None,
    order: int | None = None,
    decimate: int | None = None,
    delay: float | Literal["auto"] | None = None,
    options: Path | Mapping[str, Any] | None | None = None,
    load: Path | Mapping[str, Any] | None | None = None,
    ripple: float | Sequence[float] | Mapping[str, float | Sequence[float]] | None = None,
    elastic: bool | str | Sequence[str] = False,
    backlash: bool | str | Sequence[str] = False,
    method: Literal["ls", "essential", "rist", "tls", "rist-mh", "iv", "didim"] = "ls",
    loaded: Logs = (),
    validate: Logs = (),
    plan: ExperimentPlan | Path | None = None,
) -> Estimate:
    """Identifies the base parameters and the friction of a robot from logs of it.

    logs: one or a list; each a path (CSV, .npz, Parquet, MCAP, a rosbag2 directory), a dict of arrays ({"t": (N,),
    "q": (N, n), "tau": (N, n)}; SI), or a table with __arrow_c_stream__ (pandas, polars, pyarrow). With method="rist",
    "rist-mh", "iv" or "didim": the directory of the logs of `plan`.

    Options:
    - consistent: Physically consistent parameters: only bodies that can exist. Where the log says nothing, they
      stay near the bodies of the description [default: False]
    - gain: Torque per unit of current of a drive, N m/A [default: as the file says]. Where only some drives are
      given, the others are estimated; q5=11+-2 expects a gain near 11
    - covariance: Keep the covariance of the parameters in the estimate [default: False]
    - loaded_link: The link that carries the load of the logs with a load [default: the last]
    - friction: Friction columns per joint: viscous, coulomb, offset, asymmetric, load, rotor, smooth-coulomb=V,
      stribeck=V (V in rad/s), none, or auto, the set that best predicts parts of the logs left out of the fit
      [default: viscous,coulomb,offset]
    - weights: What rows weigh [default: joint]
    - cutoff: Cut-off of the zero-phase low-pass, Hz [default: by the frequency content of the logs]
    - order: Order of the Butterworth filter, 0 for none [default: 4]
    - decimate: Keep every N-th filtered sample [default: by the cut-off]
    - delay: Seconds by which the torques lag the positions, negative where they come before [default: 0]; or
      auto: the delay, up to a quarter of a second to both sides, with the smallest residual on rows away from
      reversals of their joint. The residual of all rows may be larger with it than without
    - options: YAML with any option of an identification; other options override it
    - load: A known load: YAML with link, mass (kg), centre_of_mass (m) and inertia about it (kg m^2). The logs of
      the experiments repeated with it, e01_loaded.csv, .., stand beside the others; no gain need be known
    - ripple: Estimate ripple of torque and gain with so many periods a turn, of a coordinate or of all
    - elastic: Estimate the springs of these coordinates, or of all; the encoders are at the motors. The equations
      end at 10 Hz then, unless cutoff= says otherwise [default: False]
    - backlash: Estimate the backlash of these joints, or of all, as elastic= does springs [default: False]
    - method: The equations to solve; all but ls and essential need the plan behind the logs [default: 'ls']
    - loaded: Logs with a load on the last link, which is identified too
    - validate: Logs that are predicted, not fitted, for the verdict
    - plan: The plan behind the logs

    With method="rist-mh" it also estimates, where asked: ripple (periods a turn of all joints, or {"q2": 12}, or
    {"q2": [6, 12]}), elastic and backlash (True for all joints, or ["q2", "q3"]: springs and gaps behind the motors, which have
    the encoders; the equations end at 10 Hz then, unless cutoff says otherwise), delay="auto". cutoff: highest frequency of
    the equations (20 Hz).

    Ctrl-C ends it. Raises rist.Error with the message of the program."""
def validate(
    model: Model,
    estimate: Estimate,
    logs: Logs,
    *,
    gain: Mapping[str, float] | None = None,
    cutoff: float | None = None,
) -> tuple[Validation, Verdict]:
    """Predicts logs with an estimate and compares: a Validation and a Verdict.

    logs as of `identify`. For an estimate of experiments, logs are the paths of motions, and gain={"q1": 2.4} (N m/A) and
    cutoff (Hz, 20) can be given.

    Options:
    - gain: Torque per unit of current of a drive, N m/A [default: that of the estimate, that of the file, or 1]
    - cutoff: Cut-off of the low-pass on position and torque, Hz [default: 20, or that of the estimate]"""
def doctor(
    model: Model,
    logs: Logs,
    *,
    options: Path | Mapping[str, Any] | None | None = None,
    gain: Mapping[str, float] | None = None,
) -> Passport:
    """Looks for what is wrong with logs before anything is fitted: units, signs, zeros, swapped columns, another robot.

    logs as of `identify`; options: a path to YAML with any option of an identification, its text, or its content as a
    dict; gain: {"q1": 2.393}, N m/A.

    Options:
    - options: YAML with any option of an identification
    - gain: Torque per unit of current of a drive, N m/A [default: as the file says]"""
def plan(
    model: Model,
    *,
    experiments: int = 8,
    criterion: Literal["determinant", "condition"] = "determinant",
    profile: Literal["bang-bang", "smooth"] = "bang-bang",
    steps: int = 5,
    configurations: int = 60,
    duration: float = 4.0,
    rate: float = 1000.0,
    starts: int = 12,
    seed: int = 1,
    nodes: int = 0,
    progress: Progress | None = None,
) -> ExperimentPlan:
    """Chooses the experiments that identify a robot best by spectrum analysis. What the description does not say is a warning.

    Options:
    - experiments: Number of experiments [default: 8]
    - criterion: What the plan makes best [default: 'determinant']
    - profile: Acceleration within a swing [default: 'bang-bang']
    - steps: Configurations of the grid per coordinate [default: 5]
    - configurations: Maximum number of configurations per kind of motion [default: 60]
    - duration: Seconds recorded in one experiment [default: 4.0]
    - rate: Sample rate of the controller, Hz [default: 1000.0]
    - starts: Starts of the search [default: 12]
    - seed: Seed of the random starts; the same seed gives the same plan [default: 1]
    - nodes: Maximum number of nodes of a branch and bound, 0 for none. It improves the plan and proves how far
      from the best it can be. It ends where the D-efficiency is within 0.001 of the best. The proof is written
      into the plan [default: 0]
    - progress: Called with (done, all, text) as work goes on"""
def simulate(
    model: Model,
    plan: ExperimentPlan | ExcitingMotion | Path,
    *,
    validation: int = 10,
    gain: Mapping[str, float] | None = None,
    load: Path | Mapping[str, Any] | None | None = None,
    feedforward: Estimate | None = None,
    seed: int = 1,
    noise_free: bool = False,
    out: Path | None = None,
    progress: Progress | None = None,
) -> tuple[Estimate, dict[str, dict[str, Numbers]]]:
    """Simulates the experiments of a plan, or an ExcitingMotion, in closed loop, with friction, noise and drive gains.

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
    model: Model,
    *,
    motion: Literal["fourier", "spline"] = "fourier",
    period: float | None = None,
    frequency: float | None = None,
    harmonics: int | None = None,
    spans: int | None = None,
    repetitions: int = 3,
    blend: float | None = None,
    rate: float = 200.0,
    limits: Path | Mapping[str, Any] | None | None = None,
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

    Options:
    - motion: The form of the motion [default: 'fourier']
    - period: Seconds of a period, of a spline from rest to rest [default: by the limits, 5 to 20]
    - frequency: Base frequency, Hz: one over the period
    - harmonics: Harmonics of the base frequency [default: 5]
    - spans: Spans of a spline: the more, the freer, and the longer the search [default: by the limits, 8 to 30]
    - repetitions: Whole periods between the blends; times that a spline is played [default: 3]
    - blend: Seconds from rest to the series, and back to rest [default: by the limits]
    - rate: Sample rate of the file to play and of the log, Hz [default: 200.0]
    - limits: YAML with tighter limits: `coordinates: {NAME: {position: [LOW, HIGH], velocity, acceleration, jerk,
      effort, power, locked: POSITION, slowed: FACTOR}}`; `all:` has them for every coordinate; `space:` has the
      room of the bodies in the base frame, m: `{floor: Z or none, walls: [{point, normal, links}], boxes: [{low,
      high, links}], distance: 0.01, own_links: true, accept: [[LINK, LINK, REASON]]}`
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
    model: Model,
    motion: ExcitingMotion,
    *,
    limits: Path | Mapping[str, Any] | None | None = None,
    after: Path | Mapping[str, Any] | None | None = None,
) -> list[str]:
    """Proves anew that a motion keeps its limits, and those of `limits`, a path to YAML or its content as a dict, too; torques
    are those of the description, or of the estimate `after`. Returns what speaks against the motion: nothing where all that
    is looked at is proven, and where all that `limits` asks for is looked at.

    Options:
    - limits: Limits of your own that the motion must keep too, as for `rist excite limits=`; those that the file
      lacks are not assumed. What a motion may leave out, `space: {floor: none, accept: ..}`, counts in this file
      alone
    - after: An estimate of this model: efforts and powers are proved with its torques instead of the
      description's"""
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
