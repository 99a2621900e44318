"""From a robot description to an exact symbolic model, generated code, and inertial parameters identified on the machine.

>>> estimate = rist.identify("arm.urdf", "log.csv")
>>> estimate.verdict, estimate["ZZR_elbow"]
>>> estimate.plot()

Everything stands on the library of Rust; `rist.Error` is what cannot be done, with the message of the program `rist`.
"""

from ._plot import Picture
from ._rist import *
from ._rist import __version__, _accumulator, _base_parameters, _estimate, _model, _passport, _verdict
