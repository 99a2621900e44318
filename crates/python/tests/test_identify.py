"""Identification: the same bytes as the program, whatever form the log has; errors; what an estimate can do."""

import pickle
import re
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

import rist
from conftest import MODELS, ROOT, log_of, write_csv


@pytest.fixture(scope="session")
def estimate(ur5, csv):
    return rist.identify(ur5, csv)


def test_the_bytes_are_those_of_the_program(program, csv, tmp_path):
    path = MODELS / "ur5.urdf"
    for flags, options in [
        ((), {}),
        (("--cutoff", "8", "--weights", "huber", "--friction", "viscous,coulomb"), dict(cutoff=8, weights="huber", friction="viscous,coulomb")),
        (("--friction", "auto", "--delay", "auto"), dict(friction="auto", delay="auto")),
        (("--consistent", "--rotor-inertia", "actuated"), dict(consistent=True)),
    ]:
        model = rist.Model.read(path, **({"rotor_inertia": "actuated"} if "--rotor-inertia" in flags else {}))
        done = program("identify", path, csv, *flags, "--out", tmp_path / "program.yaml")
        found = rist.identify(model, csv, **options)
        found.save(tmp_path / "python.yaml")
        assert (tmp_path / "python.yaml").read_bytes() == (tmp_path / "program.yaml").read_bytes(), (flags, done.stderr)
        # The program ends in the same lines; the last one names fields, which each spells for its reader.
        (said, of_program), (text, of_python) = (s.rsplit("next: ", 1) for s in (done.stdout, str(found.verdict)))
        assert said.endswith(text) and "trust: " in text and of_program and of_python
        assert found.verdict.claims and set(found.verdict.uses) == set(found.verdict.torque_errors)


def test_arrays_and_frames_are_the_file(ur5, log, csv, estimate):
    of_dict = rist.identify(ur5, log)
    np.testing.assert_array_equal(of_dict.values, estimate.values)
    np.testing.assert_array_equal(of_dict.white_sigma, estimate.white_sigma)
    columns = {"t": log["t"]} | {f"{key}{k + 1}": log[key][:, k] for key in ("q", "dq", "tau") for k in range(6)}
    for library in ("pandas", "polars", "pyarrow"):
        try:
            module = __import__(library)
        except ImportError:
            continue
        frame = module.table(columns) if library == "pyarrow" else module.DataFrame(columns)
        np.testing.assert_array_equal(rist.identify(ur5, frame).values, estimate.values)


class FrameWithoutPyarrow:
    """A frame of pandas where pyarrow is absent: its Arrow stream raises an ImportError, its columns are arrays."""

    def __init__(self, columns, error=ImportError("Missing optional dependency 'pyarrow'")):
        self.data, self.columns, self.error = columns, list(columns), error

    def __arrow_c_stream__(self, requested_schema=None):
        raise self.error

    def __getitem__(self, name):
        class Series:
            to_numpy = lambda _: np.asarray(self.data[name])

        return Series()


def test_a_frame_without_pyarrow_is_read_by_its_columns(ur5, log, estimate):
    columns = {"t": log["t"]} | {f"{key}{k + 1}": log[key][:, k] for key in ("q", "dq", "tau") for k in range(6)}
    found = rist.identify(ur5, FrameWithoutPyarrow(columns | {"note": ["x"] * len(log["t"])}))
    np.testing.assert_array_equal(found.values, estimate.values)
    # Any other error of the frame is its own.
    with pytest.raises(RuntimeError, match="broken"):
        rist.identify(ur5, FrameWithoutPyarrow(columns, RuntimeError("broken")))


class Stream:
    """What has an Arrow stream of NumPy columns, without any library of frames: pandas and polars may be absent."""

    def __init__(self, columns):
        import pyarrow

        self.table = pyarrow.table(columns)

    def __arrow_c_stream__(self, requested_schema=None):
        return self.table.__arrow_c_stream__(requested_schema)


def test_columns_of_frames(ur5, log, estimate):
    pyarrow = pytest.importorskip("pyarrow")
    columns = {"t": log["t"]} | {f"{key}{k + 1}": log[key][:, k] for key in ("q", "dq", "tau") for k in range(6)}
    # Batches with an offset, a clock in integers, singles, a note that nobody asks for.
    ticks = (1e9 * columns["t"]).round().astype("int64")
    table = pyarrow.table(columns | {"note": ["x"] * len(ticks), "state": [True] * len(ticks)})
    batched = pyarrow.Table.from_batches(table.to_batches(max_chunksize=333))
    np.testing.assert_array_equal(rist.identify(ur5, Stream(dict(zip(batched.column_names, batched.columns)))).values, estimate.values)
    sliced = pyarrow.concat_tables([table.slice(0, 5), table]).slice(5)
    np.testing.assert_array_equal(rist.identify(ur5, sliced).values, estimate.values)
    clock = table.drop(["t"]).append_column("t_ns", pyarrow.array(ticks))
    np.testing.assert_allclose(rist.identify(ur5, clock).values, estimate.values, rtol=1e-6, atol=1e-9)
    # A null is a row that does not count.
    holes = pyarrow.array([None if k == 77 else x for k, x in enumerate(columns["q1"])])
    holed = {**columns, "q1": np.where(np.arange(len(ticks)) == 77, np.nan, columns["q1"])}
    index = table.column_names.index("q1")
    np.testing.assert_array_equal(rist.identify(ur5, table.set_column(index, "q1", holes)).values, rist.identify(ur5, holed).values)
    with pytest.raises(rist.Error, match="column `q1`: `a value of the Arrow type u` is not a number"):
        rist.identify(ur5, table.set_column(index, "q1", pyarrow.array(["x"] * len(ticks))))


def literal(flag):
    """The value of a flag in the syntax of Python."""
    return {name: int(value) for name, value in (pair.split("=") for pair in flag.split(","))}


def test_errors_are_those_of_the_program(ur5, program, csv, tmp_path):
    def message(*arguments, **options):
        with pytest.raises(rist.Error) as raised:
            rist.identify(ur5, *arguments, **options)
        return str(raised.value)

    (tmp_path / "short.csv").write_text("t,q1\n0,1\n1,2\n")
    for path in ("no/such.csv", tmp_path / "short.csv"):
        # The program shows the line at fault below, and has its own words for options.
        said = program("identify", MODELS / "ur5.urdf", path).stderr.splitlines()[0]
        said = re.sub(r"--lock (\S+), with", lambda flag: f"lock={literal(flag[1])}, with", said)
        assert said == f"rist: {message(path)}"
    assert "no option `cutof` (did you mean cutoff=?); there are arm, backlash, consistent, covariance, cutoff" in message(csv, cutof=3)
    assert message(csv, cutoff="fast") == "identify: cutoff= is \"fast\"; expected is a number"
    assert "there is no friction term `stribek`; there are viscous" in message(csv, friction="stribek")
    assert "one of none, joint" in message(csv, weights="hubert")
    assert "auto and none stand alone" in message(csv, friction=["auto", "viscous"])
    assert "given twice" in message([csv, csv])
    assert "a log is a path, a dict of arrays" in message(3.5)
    assert "unknown field" in message(csv, options="signals: 3")
    assert "needs the plan" in message(csv, method="rist")
    assert "weights=: method='rist' does not use that; method='ls' or essential does" in message(csv, method="rist", weights="huber")
    words = {"t": np.arange(60.0), "q1": ["a"] * 60, "tau1": np.arange(60.0)}
    with pytest.raises(rist.Error, match="column `q1`: `a value of type list` is not a number"):
        rist.identify(rist.Model.read(MODELS / "planar2r.yaml"), words | {"q2": words["t"], "tau2": words["t"]})


def test_what_an_estimate_can_do(ur5, log, csv, estimate, tmp_path):
    names = estimate.names
    assert len(names) == len(estimate.values) == len(estimate.sigma) == len(estimate.units) == len(estimate.status)
    truth = dict(zip(ur5.base_parameters.names, ur5.nominal_parameters))
    for name, value, sigma in zip(names, estimate.values, estimate.sigma):
        if name in truth:
            # Six deviations: parts and bands are few draws.
            assert abs(value - truth[name]) < 6 * sigma + 1e-3, name
    assert list(estimate.table) == ["name", "value", "sigma", "white_sigma", "unit", "status"]
    assert estimate.parameters[names[0]] == estimate.values[0]
    assert estimate.covariance is None
    covariance = rist.identify(ur5, csv, covariance=True).covariance
    np.testing.assert_allclose(np.sqrt(np.diag(covariance)), estimate.sigma, rtol=1e-9)
    assert estimate.verdict.trust in ("yes", "with care", "no") and estimate.verdict.next
    assert estimate.total < 0.1 and "trust:" in repr(estimate) and "<iframe" in estimate._repr_html_()

    other = log_of(ur5, seed=2)
    found = estimate.predict(other)
    assert found["predicted"].shape == found["measured"].shape == (len(found["t"]), 6)
    counts = ~np.isnan(found["predicted"])
    left = np.linalg.norm((found["predicted"] - found["measured"])[counts]) / np.linalg.norm(found["measured"][counts])
    validation, verdict = rist.validate(ur5, estimate, other)
    # Both sum the squares of the same rows, in another order.
    assert left == pytest.approx(validation.total, rel=1e-9) and verdict.trust != "no"
    assert [len(x["t"]) for x in estimate.predict([other, csv])] == [len(found["t"])] * 2

    estimate.save(tmp_path / "estimate.yaml")
    again = rist.Estimate.read(tmp_path / "estimate.yaml", ur5)
    np.testing.assert_array_equal(again.predict(other)["predicted"], found["predicted"])
    estimate.report(tmp_path / "report.html", validation=validation)
    assert "<html" in (tmp_path / "report.html").read_text()
    with pytest.raises(rist.Error, match="made with `ur5"):
        rist.Estimate.read(tmp_path / "estimate.yaml", rist.Model.read(MODELS / "scara.yaml"))
    with pytest.raises(rist.Error, match="consistent=True"):
        estimate.write_urdf(tmp_path / "new.urdf")
    with pytest.raises(rist.Error, match="an input"):
        estimate.save(csv)

    copy = pickle.loads(pickle.dumps(estimate))
    assert copy.to_yaml() == estimate.to_yaml() and str(copy.verdict) == str(estimate.verdict)
    np.testing.assert_array_equal(copy.predict(other)["predicted"], found["predicted"])
    np.testing.assert_array_equal(ur5.torque(other["q"], parameters=estimate), ur5.torque(other["q"], parameters=copy))


def test_bodies_go_back_into_the_urdf(ur5, csv, tmp_path):
    found = rist.identify(ur5, csv, consistent=True)
    found.write_urdf(tmp_path / "new.urdf", anyway=True)
    # A pickle has the bodies too, as a worker sends them; the file has none, and says where they are.
    pickle.loads(pickle.dumps(found)).write_urdf(tmp_path / "pickled.urdf", anyway=True)
    assert (tmp_path / "pickled.urdf").read_bytes() == (tmp_path / "new.urdf").read_bytes()
    found.save(tmp_path / "estimate.yaml")
    read = rist.Estimate.read(tmp_path / "estimate.yaml", ur5)
    for copy in (read, pickle.loads(pickle.dumps(read))):
        with pytest.raises(rist.Error, match="its file, which holds no bodies.*consistent=True.*or on a pickle"):
            copy.write_mjcf(tmp_path / "joints.xml", anyway=True)
    again = rist.Model.read(tmp_path / "new.urdf")
    assert again.base_parameters.names == ur5.base_parameters.names
    with pytest.raises(rist.Error, match="an input"):
        found.write_urdf(MODELS / "ur5.urdf", anyway=True)
    found.write_mjcf(tmp_path / "joints.xml", anyway=True)
    assert "<joint" in (tmp_path / "joints.xml").read_text()


def test_a_load_and_a_doctor(ur5, log, csv):
    heavy = dict(log, tau=log["tau"] + ur5.gravity(log["q"]) * 0.1)
    found = rist.identify(ur5, csv, loaded=heavy)
    assert "load on" in found.load
    check = rist.doctor(ur5, dict(log, tau=-log["tau"]))
    assert check.is_gross and any("sign" in finding for finding in check.findings)
    assert not rist.doctor(ur5, csv).is_gross


def test_every_class_is_pickled(ur5, log, csv, estimate):
    """What a class shows is what its pickle shows; plans, motions and sums have tests of their own."""
    heavy = rist.identify(ur5, csv, loaded=dict(log, tau=log["tau"] + ur5.gravity(log["q"]) * 0.1))
    validation, verdict = rist.validate(ur5, estimate, log_of(ur5, seed=2))
    check = rist.doctor(ur5, dict(log, tau=-log["tau"]))
    for thing in (ur5, ur5.base_parameters, heavy, validation, verdict, check):
        copy = pickle.loads(pickle.dumps(thing))
        assert type(copy) is type(thing) and repr(copy) == repr(thing)
        # The page of an estimate lists each claim, of which a pickle holds the sentence alone.
        assert copy._repr_html_() == thing._repr_html_() or (thing is heavy and "<iframe" in copy._repr_html_())
    copy = pickle.loads(pickle.dumps(heavy))
    assert copy.load == heavy.load != None and copy.findings == heavy.findings
    copy = pickle.loads(pickle.dumps(check))
    assert copy.is_gross and copy.findings == check.findings and copy.not_checked == check.not_checked
    np.testing.assert_array_equal(pickle.loads(pickle.dumps(ur5.base_parameters)).matrix, ur5.base_parameters.matrix)
    error = pickle.loads(pickle.dumps(rist.Error("where and what")))
    assert type(error) is rist.Error and str(error) == "where and what"


def test_former_names_warn(ur5, log):
    with pytest.warns(DeprecationWarning, match="LogCheck"):
        assert rist.Passport is rist.LogCheck
    check = rist.doctor(ur5, log)
    with pytest.warns(DeprecationWarning, match="not_checked"):
        assert check.untold == check.not_checked
    with pytest.warns(DeprecationWarning, match="nominal_parameters"):
        assert list(ur5.described_parameters) == list(ur5.nominal_parameters)
    with pytest.raises(AttributeError):
        rist.no_such_name


@pytest.mark.parametrize("library", ["pyarrow", "polars", "pandas"])
def test_the_table_is_an_arrow_stream(ur5, log, library):
    """Rows of a standstill leave inertias open: they are nulls."""
    module = pytest.importorskip(library, reason=f"{library} is not installed")
    still = {**log, "q": log["q"].copy(), "dq": log["dq"].copy()}
    still["q"][:, 5], still["dq"][:, 5] = 0.3, 0.0
    found = rist.identify(ur5, still)
    assert None in found.parameters.values()
    if library == "pyarrow":
        table = module.table(found)
        values, names = table["value"].to_pylist(), table["name"].to_pylist()
        assert table["value"].null_count == sum(x is None for x in values) > 0
    elif library == "polars":
        table = module.DataFrame(found)
        values, names = table["value"].to_list(), table["name"].to_list()
    else:
        if not hasattr(module.DataFrame, "from_arrow"):
            pytest.skip("this pandas reads no Arrow streams: DataFrame.from_arrow is of 3.0")
        table = module.DataFrame.from_arrow(found)
        names, values = list(table["name"]), [None if module.isna(x) else x for x in table["value"]]
    assert dict(zip(names, values)) == found.parameters
    assert list(table["unit"].to_pylist() if library == "pyarrow" else table["unit"]) == found.units
    # A stream that nobody reads is released with its capsule.
    found.__arrow_c_stream__()


def test_ctrl_c_ends_long_work():
    """A signal to a process that plans for minutes: it ends, with KeyboardInterrupt, long before the plan would."""
    # A job in the background of a shell ignores the signal, and its children too.
    code = """
import rist, signal, sys
signal.signal(signal.SIGINT, signal.default_int_handler)
model = rist.Model.read(sys.argv[1])
print("go", flush=True)
try:
    rist.plan(model, experiments=30, starts=10000, configurations=200)
except KeyboardInterrupt:
    print("interrupted", flush=True)
"""
    run = subprocess.Popen([sys.executable, "-c", code, str(MODELS / "ur5.urdf")], stdout=subprocess.PIPE, text=True)
    assert run.stdout.readline() == "go\n"
    time.sleep(1.0)
    run.send_signal(signal.SIGINT)
    out, _ = run.communicate(timeout=120)
    assert out == "interrupted\n" and run.returncode == 0


def test_what_a_callback_raises_ends_the_work(ur5):
    seen = []

    def progress(done, all, text):
        seen.append((done, all, text))
        raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough"):
        rist.plan(ur5, starts=2000, configurations=20, progress=progress)
    assert seen[0][:2] == (1, 2000) and "best" in seen[0][2] and len(seen) < 2000


def test_rotors_that_a_urdf_cannot_say():
    """The estimate knows the model that it was made with, in a pickle too."""
    path = MODELS / "ur5.urdf"
    geared = rist.Model.read(path, rotor_inertia="actuated")
    names = geared.coordinates
    t = np.arange(0.0, 10.0, 0.01)
    phase = np.arange(1.0, 7.0)
    q = np.sin(np.outer(t, 0.7 + 0.3 * phase) + phase)
    dq = (0.7 + 0.3 * phase) * np.cos(np.outer(t, 0.7 + 0.3 * phase) + phase)
    ddq = -((0.7 + 0.3 * phase) ** 2) * q
    plain = rist.Model.read(path)
    random = np.random.default_rng(7)
    tau = plain.torque(q, dq, ddq) + 0.5 * ddq + 0.4 * dq + 0.3 * np.sign(dq) + 0.05 * random.normal(size=q.shape)
    log = {"t": t, "q": q, "dq": dq, "tau": tau}
    estimate = rist.identify(plain, log)
    assert any("rotor inertias are among" in remark for remark in estimate.remarks)
    assert len(names) == 6 and len(estimate.names) == len(geared.base_parameters) + 18
    again = pickle.loads(pickle.dumps(estimate))
    for one in (estimate, again):
        assert one.predict(log)["predicted"].shape[1] == 6
    pinned = rist.identify(rist.Model.read(path, rotor_inertia="none"), log)
    assert not any("rotor inertias are among" in remark for remark in pinned.remarks)


def test_a_wrench_log_gives_the_load_back():
    """A log made by Newton and Euler has its load back within five deviations; what is no such log is refused."""
    m, c, about = 1.3, np.array([0.02, -0.01, 0.11]), np.diag([0.004, 0.005, 0.002])
    n, g = 4001, np.array([0.0, 0.0, -9.81])
    t = np.arange(n) / 500
    # A smooth turn about three axes and a smooth course: their derivatives are taken by differences of a finer clock.
    angle = lambda t: np.stack([0.7 * np.sin(2.1 * t), 0.8 * np.sin(1.7 * t + 1), 0.9 * np.sin(2.6 * t)], -1)
    place = lambda t: np.stack([0.2 * np.sin(2.3 * t), 0.15 * np.cos(1.9 * t), 0.1 * np.sin(2.9 * t)], -1)

    def turn(t):
        (r, p, y) = angle(np.atleast_1d(t)).T
        (cr, cp, cy), (sr, sp, sy) = np.cos([r, p, y]), np.sin([r, p, y])
        rows = [[cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr], [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr], [-sp, cp * sr, cp * cr]]
        return np.moveaxis(np.array(rows), -1, 0)

    h = 1e-4
    centre = lambda t: place(t) + turn(t) @ c
    omega = lambda t: np.stack([(d := (turn(t + h) - turn(t - h)) / (2 * h) @ turn(t).transpose(0, 2, 1))[:, 2, 1], d[:, 0, 2], d[:, 1, 0]], -1)
    spin = lambda t: np.einsum("nij,njk,nlk,nl->ni", turn(t), about[None].repeat(len(t), 0), turn(t), omega(t))
    force = m * ((centre(t + h) - 2 * centre(t) + centre(t - h)) / h**2 - g)
    moment = (spin(t + h) - spin(t - h)) / (2 * h) + np.cross(centre(t) - place(t), force)
    noise = np.random.default_rng(3)
    back = lambda x: np.einsum("nji,nj->ni", turn(t), x)
    forces, moments = back(force) + 0.1 * noise.normal(size=(n, 3)), back(moment) + 0.005 * noise.normal(size=(n, 3))
    names = ["t", "fx", "fy", "fz", "tx", "ty", "tz", "x", "y", "z", "roll", "pitch", "yaw"]
    log = dict(zip(names, [t, *forces.T, *moments.T, *place(t).T, *angle(t).T]))
    found = rist.wrench(log)
    assert abs(found["body"]["mass"] - m) < 0.01 and np.abs(np.array(found["body"]["centre_of_mass"]) - c).max() < 1e-3
    [mass] = [p["estimate"] for p in found["parameters"] if p["name"] == "M"]
    assert abs(mass["value"] - m) < 5 * mass["sigma"] and not found["is_reaction"]
    assert found["rows"] == n and "set_target_payload" in found["text"]
    assert "link: flange" in rist.wrench(log, link="flange")["text"]
    assert found["verdict"]["trust"] == "yes" and not found["verdict"]["reasons"]
    # Torques in N mm have no body, and a correction that gives it back.
    millis = {**log, **{name: 1000 * log[name] for name in ("tx", "ty", "tz")}}
    wrong = rist.wrench(millis)
    assert wrong["body"] is None and wrong["verdict"]["trust"] == "no" and "torque: 0.001" in wrong["verdict"]["next"]
    assert rist.wrench(millis, options={"corrections": {"torque": 0.001}})["verdict"]["trust"] == "yes"
    with pytest.raises(rist.Error, match="force"):
        rist.wrench({"t": t, "q": t})
    with pytest.raises(rist.Error, match="one log is expected"):
        rist.wrench([log, log])


def converted(program, path, out):
    """Obeys the command in the refusal of a file, as a machine would."""
    said = program("doctor", MODELS / "ur5.urdf", path).stderr
    command = re.search(r"`python -c \"(.*)\"`", said, re.DOTALL)
    assert command, said
    code = " ".join(command[1].split("\n")).replace("'IN'", repr(str(path))).replace("'OUT.npz'", repr(str(out)))
    subprocess.run([sys.executable, "-c", code], check=True)


@pytest.mark.parametrize("protocol", range(pickle.HIGHEST_PROTOCOL + 1))
@pytest.mark.parametrize("as_rows", [False, True])
def test_the_command_of_a_refused_pickle_converts_it(program, ur5, log, estimate, tmp_path, protocol, as_rows):
    rows = [{key: values[k].tolist() for key, values in log.items()} for k in range(len(log["t"]))]
    path = tmp_path / "log.pickle"
    path.write_bytes(pickle.dumps(rows if as_rows else log, protocol=protocol))
    converted(program, path, tmp_path / "log.npz")
    np.testing.assert_array_equal(rist.identify(ur5, tmp_path / "log.npz").values, estimate.values)


def test_the_command_of_a_refused_hdf5_converts_it(program, ur5, log, estimate, tmp_path):
    h5py = pytest.importorskip("h5py")
    with h5py.File(tmp_path / "log.h5", "w") as file:
        for key, values in log.items():
            file[f"robot/{key}"] = values
    converted(program, tmp_path / "log.h5", tmp_path / "log.npz")
    names = [f"robot_{key}" for key in log]
    assert set(np.load(tmp_path / "log.npz")) == set(names)


def test_a_push_is_found_in_a_replay(ur5, log, csv, tmp_path):
    """A torque added to one joint is contact with its times; without it there is none. The series are those of the log."""
    estimate = rist.identify(ur5, csv, covariance=True)
    quiet = rist.replay(ur5, estimate, csv)
    assert quiet["contacts"] == [] and quiet["loads"] == [] and "contact: none" in quiet["text"]
    pushed = {key: np.array(value) for key, value in log.items()}
    t = pushed["t"]
    middle = t[0] + 0.5 * (t[-1] - t[0])
    at = (t > middle) & (t < middle + 0.4)
    size = 20 * np.sqrt(np.mean(quiet["series"]["beyond"][:, 1] ** 2)) + 2 * np.max(quiet["series"]["band"][:, 1])
    pushed["tau"][at, 1] += size
    found = rist.replay(ur5, estimate, pushed)
    (contact,) = found["contacts"]
    # The motor's torque grew, so the external torque has the other sign.
    assert contact["joint"] == ur5.coordinates[1] and contact["torque"] < 0
    assert abs(contact["start"] - middle) < 0.1
    series = found["series"]
    assert series["torque"].shape == series["band"].shape == (len(series["t"]), 6)
    assert series["contact"].max() == 1 and set(series) == {"t", "torque", "beyond", "band", "contact", "mass"}
    assert "<h2>Contact</h2>" in found["page"] and "rist.replay" in found["page"]
    with pytest.raises(rist.Error, match="one log is expected, and 2 are given"):
        rist.replay(ur5, estimate, [csv, csv])


def test_a_monitor_takes_a_sample_at_a_time(ur5, log, csv):
    """Sample by sample it says what a replay of the whole log says; a sample that is no number is not used."""
    estimate = rist.identify(ur5, csv, covariance=True)
    held = rist.replay(ur5, estimate, csv)["series"]
    t, (q, dq, tau) = np.array(log["t"]), (np.array(log[key]) for key in ("q", "dq", "tau"))
    monitor = rist.Monitor(ur5, estimate, period=float(np.mean(np.diff(t))))
    assert monitor.coordinates == ur5.coordinates
    cycles = [monitor.step(*sample) for sample in zip(t, q, dq, tau)]
    # The text of the log has rounded numbers: the file was written with all digits, so only sums of another order differ.
    for key in ("torque", "beyond", "band"):
        assert np.allclose([cycle[key] for cycle in cycles], held[key], rtol=1e-6, atol=1e-6), key
    assert not any(cycle["contact"] for cycle in cycles) and cycles[-1]["changes"] == 0
    assert all(cycle["candidate"] is None for cycle in cycles)
    assert monitor.step(t[-1] + 1, q[-1] * np.nan, dq[-1], tau[-1]) is None
    assert monitor.step(t[-1] + 2, q[-1], dq[-1], tau[-1])["contact"] is False
    with pytest.raises(rist.Error, match="dq has 5 numbers: 6 are expected"):
        monitor.step(t[-1] + 3, q[-1], dq[-1][:5], tau[-1])
    with pytest.raises(rist.Error, match="a positive number is expected"):
        rist.Monitor(ur5, estimate, period=0.0)


def test_a_calibration_is_that_of_the_program(program, tmp_path):
    folder = ROOT.parent / "shared/data/calibration/ur10_camera"
    if not folder.exists():
        pytest.skip("../shared is absent: its measured poses are not calibrated")
    found = rist.calibrate(rist.Model.read(folder / "ur10.urdf", angles="as-given"), folder / "poses.csv")
    done = program("calibrate", folder / "ur10.urdf", folder / "poses.csv", "--angles", "as-given", "--write-urdf", tmp_path / "c.urdf")
    assert found["text"].splitlines()[:10] == done.stdout.splitlines()[:10] and "mm" in found["text"]
    assert found["urdf"] == (tmp_path / "c.urdf").read_text() and found["zeros"].startswith("joint,zero,interval,unit")
    with pytest.raises(rist.Error, match="no_link"):
        rist.calibrate(folder / "ur10.urdf", folder / "poses.csv", tip="no_link")
