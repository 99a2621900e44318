"""From a robot description to an exact symbolic model, generated code, and inertial parameters identified on the machine.

>>> estimate = rist.identify("arm.urdf", "log.csv")
>>> estimate.verdict, estimate["ZZR_elbow"]
>>> estimate.plot()

Everything stands on the library of Rust; `rist.Error` is what cannot be done, with the message of the program `rist`.
"""

from ._plot import Picture
from ._rist import *
from ._rist import __version__, _accumulator, _base_parameters, _estimate, _log_check, _model, _verdict


def __getattr__(name):
    """The former names of what is called otherwise; they go with the next version."""
    if name != "Passport":
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    import warnings

    warnings.warn("rist.Passport is called rist.LogCheck", DeprecationWarning, stacklevel=2)
    return LogCheck
