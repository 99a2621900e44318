"""What a caller hands over: streams that were taken, masked, complex and timed arrays, arrays that another thread resizes."""

import ctypes
import threading

import numpy as np
import pytest

import rist
from conftest import MODELS, log_of


class Stream(ctypes.Structure):
    """The Arrow C stream interface; all null: it was released."""

    _fields_ = [(name, ctypes.c_void_p) for name in ("get_schema", "get_next", "get_last_error", "release", "private")]


class Taken:
    """A frame whose stream another reader took."""

    def __init__(self):
        self.stream = Stream()

    def __arrow_c_stream__(self, requested_schema=None):
        new = ctypes.pythonapi.PyCapsule_New
        new.restype, new.argtypes = ctypes.py_object, [ctypes.c_void_p, ctypes.c_char_p, ctypes.c_void_p]
        return new(ctypes.addressof(self.stream), b"arrow_array_stream", None)


@pytest.fixture
def model():
    return rist.Model.read(MODELS / "planar2r_vertical.yaml")


def test_a_released_stream_is_refused(model):
    with pytest.raises(rist.Error, match="was released"):
        rist.doctor(model, Taken())


def test_a_mask_is_refused_of_states_and_left_out_of_logs(model):
    q = np.ma.array(np.zeros((3, 2)), mask=[[0, 0], [1, 0], [0, 0]])
    with pytest.raises(rist.Error, match="q: some of its values are masked"):
        model.torque(q)
    assert model.torque(np.ma.array(np.zeros((3, 2)))).shape == (3, 2)
    log = log_of(model)
    masked = np.ma.array(log["q"], mask=np.zeros(log["q"].shape, bool))
    masked.mask[77, 0] = True
    whole = dict(log, q=np.where(masked.mask, np.nan, log["q"]))
    found, expected = (rist.identify(model, x).to_yaml() for x in (dict(log, q=masked), whole))
    assert found == expected


def test_imaginary_parts_are_refused(model):
    with pytest.raises(rist.Error, match="q: an array of real numbers is expected, and it holds complex numbers"):
        model.torque(np.zeros((3, 2), complex))


def test_times_with_a_unit_are_seconds(model):
    log = log_of(model)
    nanoseconds = np.round(log["t"] * 1e9).astype("int64")
    expected = rist.identify(model, dict(log, t=nanoseconds / 1e9)).to_yaml()
    for t in (nanoseconds.astype("m8[ns]"), nanoseconds.astype("M8[ns]") + np.timedelta64(1_760_000_000, "s")):
        assert rist.identify(model, dict(log, t=t)).to_yaml() == expected
    with pytest.raises(rist.Error, match="times with a unit"):
        model.torque(np.zeros((3, 2), "m8[s]"))


def test_timestamps_of_arrow_are_seconds(model):
    pyarrow = pytest.importorskip("pyarrow")
    log = log_of(model)
    nanoseconds = np.round(log["t"] * 1e9).astype("int64")
    columns = {f"{key}{k + 1}": log[key][:, k] for key in ("q", "dq", "tau") for k in range(2)}
    expected = rist.identify(model, pyarrow.table({"t": nanoseconds / 1e9, **columns})).to_yaml()
    for kind, shift in ((pyarrow.duration("ns"), 0), (pyarrow.timestamp("ns"), 1_760_000_000_000_000_000)):
        t = pyarrow.array(nanoseconds + shift, kind)
        found = rist.identify(model, pyarrow.table({"t_ns": t, **columns})).to_yaml()
        assert found == expected


def test_columns_of_formats_of_polars_alone_are_left_out(model):
    polars = pytest.importorskip("polars")
    log = log_of(model)
    frame = polars.DataFrame({"t": log["t"]} | {f"{key}{k + 1}": log[key][:, k] for key in ("q", "dq", "tau") for k in range(2)})
    wide, name = polars.lit(1).cast(polars.Int128), polars.lit("a").cast(polars.Categorical)
    found = rist.identify(model, frame.with_columns(count=wide, phase=name, parts=polars.lit([1, 2])))
    assert found.to_yaml() == rist.identify(model, frame).to_yaml()
    with pytest.raises(rist.Error, match="column `q1`: `a value of the Arrow type _pli128` is not a number"):
        rist.identify(model, frame.with_columns(q1=wide))


def test_an_array_is_not_resized_while_it_is_read(model):
    states, refused = np.zeros((200_000, 2)), []
    done = threading.Event()

    def resize():
        while not done.is_set():
            try:
                states.resize((1, 2), refcheck=False)
                return
            except ValueError as why:
                refused.append(why)

    started = threading.Event()
    outcome = []

    def evaluate():
        started.set()
        outcome.append(model.base_regressor(states, states, states).shape[0])

    work = threading.Thread(target=evaluate)
    work.start()
    started.wait()
    other = threading.Thread(target=resize)
    other.start()
    work.join()
    done.set()
    other.join()
    assert outcome[0] in (1, 200_000)


def test_endless_files_are_refused():
    for read in (rist.Estimate.read, rist.ExperimentPlan.read, rist.ExcitingMotion.read, rist.Validation.read):
        with pytest.raises(rist.Error, match="larger than 16 MiB"):
            read("/dev/zero")


def test_no_failure_is_beyond_except_exception(model):
    for log in ({"t": [0.0], "q": [[np.inf, 0]], "tau": [[0, 0]]}, {}, [], {"t": []}, "/dev/null"):
        with pytest.raises(Exception):
            rist.identify(model, log)
