"""From a robot description to an exact symbolic model, generated code, and inertial parameters identified from logs of the robot.

>>> estimate = rist.identify("arm.urdf", "log.csv")
>>> estimate.verdict, estimate["ZZR_elbow"]
>>> estimate.plot()

The package uses the library in Rust. If something cannot be done, it raises `rist.Error` with the message of the program `rist`.
"""

from ._plot import Picture
from ._rist import *
from ._rist import __version__, _accumulator, _base_parameters, _estimate, _log_check, _model, _verdict


def __getattr__(name):
    """Former names of things that have a new name. The next version removes the former names."""
    if name != "Passport":
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    import warnings

    warnings.warn("rist.Passport is called rist.LogCheck", DeprecationWarning, stacklevel=2)
    return LogCheck
