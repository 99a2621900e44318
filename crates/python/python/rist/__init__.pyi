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
    ) -> Model: ...
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
    ) -> Model: ...
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
    @overload
    def generate(self, language: Literal["rust"] = "rust", functions: Sequence[str] = ..., header: str | None = None) -> str: ...
    @overload
    def generate(self, language: Literal["c"], functions: Sequence[str] = ..., header: str | None = None) -> tuple[str, str]: ...

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
    def total(self) -> float: ...
    @property
    def cross_validation(self) -> float | None: ...
    @property
    def cutoff(self) -> float: ...
    @property
    def condition_number(self) -> float: ...
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
        cutoff: float | None = None,
        order: int | None = None,
        decimate: int | None = None,
        delay: float | None = None,
        friction: str | Sequence[str] | None = None,
        weights: str | None = None,
        gain: Mapping[str, float] | None = None,
        options: Path | Mapping[str, Any] | None = None,
    ) -> None: ...
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
    cutoff: float | None = None,
    order: int | None = None,
    decimate: int | None = None,
    delay: float | Literal["auto"] | None = None,
    friction: str | Sequence[str] | None = None,
    weights: str | None = None,
    gain: Mapping[str, float | tuple[float, float]] | None = None,
    consistent: bool = False,
    covariance: bool = False,
    loaded: Logs = (),
    loaded_link: str | None = None,
    validate: Logs = (),
    options: Path | Mapping[str, Any] | None = None,
    method: Literal["ls", "essential", "rist", "rist-mh", "iv", "didim"] = "ls",
    plan: ExperimentPlan | Path | None = None,
    load: Path | Mapping[str, Any] | None = None,
    ripple: float | Sequence[float] | Mapping[str, float | Sequence[float]] | None = None,
    elastic: bool | str | Sequence[str] = False,
    play: bool | str | Sequence[str] = False,
) -> Estimate: ...
def validate(
    model: Model,
    estimate: Estimate,
    logs: Logs,
    *,
    gain: Mapping[str, float] | None = None,
    cutoff: float | None = None,
) -> tuple[Validation, Verdict]: ...
def doctor(
    model: Model,
    logs: Logs,
    *,
    options: Path | Mapping[str, Any] | None = None,
    gain: Mapping[str, float] | None = None,
) -> Passport: ...
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
) -> ExperimentPlan: ...
def simulate(
    model: Model,
    plan: ExperimentPlan | ExcitingMotion | Path,
    *,
    out: Path | None = None,
    validation: int = 10,
    gain: Mapping[str, float] | None = None,
    load: Path | Mapping[str, Any] | None = None,
    feedforward: Estimate | None = None,
    seed: int = 1,
    noise_free: bool = False,
    progress: Progress | None = None,
) -> tuple[Estimate, dict[str, dict[str, Numbers]]]: ...
def excite(
    model: Model,
    *,
    motion: Literal["fourier", "spline"] = "fourier",
    period: float | None = None,
    frequency: float | None = None,
    blend: float | None = None,
    harmonics: int | None = None,
    spans: int | None = None,
    repetitions: int = 3,
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
) -> ExcitingMotion: ...
def check(model: Model, motion: ExcitingMotion, *, limits: Path | Mapping[str, Any] | None = None) -> list[str]: ...
def compare(reference: Accumulator, robots: Mapping[str, Accumulator], fdr: float = 0.05) -> Comparison: ...
