"""What people try first: a path for a model, a name for a parameter, equality, dicts, plots, pages, warnings."""

import pickle
import re
import warnings

import numpy as np
import pytest

import rist
from conftest import MODELS, ROOT, log_of

URDF, LOG, OTHER = MODELS / "ur5.urdf", ROOT / "docs/ur5/log.csv", ROOT / "docs/ur5/other.csv"


@pytest.fixture(scope="module")
def estimate():
    return rist.identify(URDF, LOG, validate=OTHER)


@pytest.fixture(scope="module")
def motion(ur5):
    return rist.excite(ur5, period=5.0, repetitions=1, starts=1, iterations=5)


@pytest.fixture(params=[True, False], ids=["matplotlib", "without"])
def has_matplotlib(request, monkeypatch):
    if not request.param:
        monkeypatch.setattr(rist._plot, "_pyplot", lambda: None)
    else:
        pytest.importorskip("matplotlib", reason="matplotlib is not installed: its plots are not drawn")
        monkeypatch.setenv("MPLBACKEND", "agg")
    yield request.param
    if request.param:
        import matplotlib.pyplot as pyplot

        pyplot.close("all")


def test_a_model_is_made_of_a_path():
    model = rist.Model(URDF)
    assert model == rist.Model.read(str(URDF)) == rist.Model.parse(URDF.read_text())
    assert hash(model) == hash(rist.Model(URDF)) and len({model, rist.Model(URDF)}) == 1
    assert model != rist.Model(URDF, rotor_inertia="actuated") and model != "ur5" and model != rist.Model(MODELS / "scara.yaml")
    with pytest.raises(rist.Error, match=r"did you mean rotor_inertia=\?"):
        rist.Model(URDF, rotor_inertias="all")
    assert rist.Model(MODELS / "planar2r_vertical.yaml").to_dict()["base"]


def test_a_path_is_taken_wherever_a_model_is(ur5, estimate, motion, tmp_path):
    assert rist.identify(ur5, LOG, validate=OTHER) == estimate
    assert rist.doctor(URDF, LOG) == rist.doctor(ur5, LOG)
    assert rist.validate(URDF, estimate, OTHER) == rist.validate(ur5, estimate, OTHER)
    assert rist.excite(str(URDF), period=5.0, repetitions=1, starts=1, iterations=5) == motion
    motion.save(tmp_path / "motion.yaml")
    assert rist.check(URDF, tmp_path / "motion.yaml") == rist.check(ur5, motion)
    truth, logs = rist.simulate(URDF, tmp_path / "motion.yaml", validation=0, noise_free=True)
    assert truth == rist.simulate(ur5, motion, validation=0, noise_free=True)[0] and list(logs) == ["motion"]
    estimate.save(tmp_path / "estimate.yaml")
    again = rist.Estimate.read(tmp_path / "estimate.yaml", URDF)
    assert again == estimate and again.model == estimate.model
    # An option that is repeated goes over the estimate's, key by key: its rotors stay.
    turned = rist.identify(rist.Model(URDF, base=(0.1, 0, 0), rotor_inertia="actuated"), LOG)
    turned.save(tmp_path / "turned.yaml")
    assert rist.Estimate.read(tmp_path / "turned.yaml", rist.Model(URDF, base=(0.1, 0, 0))).model == turned.model
    with pytest.raises(rist.Error, match="base= is 0.1,0,0 there and 0.2,0,0 here"):
        rist.Estimate.read(tmp_path / "turned.yaml", rist.Model(URDF, base=(0.2, 0, 0)))
    sums = rist.Accumulator(URDF, cutoff=10.0).update(LOG)
    sums.save(tmp_path / "sums.tri")
    assert rist.Accumulator.read(tmp_path / "sums.tri", URDF).solve() == sums.solve()
    plan = rist.plan(MODELS / "planar2r_vertical.yaml", experiments=4, starts=1, configurations=5)
    assert plan == pickle.loads(pickle.dumps(plan))
    with pytest.raises(rist.Error, match="a model is a rist.Model or the path of its description .*, not int"):
        rist.identify(3, LOG)


def test_rotors_may_be_chosen_where_they_are_fitted(ur5):
    """A URDF cannot say them; the remark and the error that name the field name a keyword that is there."""
    chosen = rist.identify(URDF, LOG, rotor_inertia="actuated")
    assert chosen == rist.identify(rist.Model(URDF, rotor_inertia="actuated"), LOG)
    assert chosen == rist.identify(ur5, LOG, rotor_inertia="actuated")
    assert chosen.model.base_parameters.names == rist.Model(URDF, rotor_inertia="actuated").base_parameters.names
    # The estimate predicts with its own model, whichever is given of the same description.
    validation, verdict = rist.validate(ur5, chosen, OTHER)
    assert validation.total < 0.02 and verdict.trust != "no"
    with pytest.raises(rist.Error, match="expected is one of none, actuated, all"):
        rist.identify(URDF, LOG, rotor_inertia="some")
    with pytest.raises(rist.Error, match="made with"):
        rist.validate(MODELS / "scara.yaml", chosen, OTHER)


def test_parameters_are_found_by_name(estimate, ur5):
    name = estimate.names[0]
    assert estimate[name] == estimate[0] == estimate.values[0] == estimate.parameters[name]
    assert estimate[-1] == estimate[len(estimate) - 1] and name in estimate and "ZZ9" not in estimate
    assert list(estimate) == estimate.names and len(estimate) == len(estimate.names)
    with pytest.raises(KeyError, match=r"there is no parameter ZZR_sholder_pan \(did you mean `ZZR_shoulder_pan`"):
        estimate["ZZR_sholder_pan"]
    with pytest.raises(KeyError, match="there is no parameter mass; there are ZZR_"):
        estimate["mass"]
    for index in (len(estimate), -len(estimate) - 1, 2**62, -(2**62)):
        with pytest.raises(IndexError):
            estimate[index]
    with pytest.raises(TypeError):
        estimate[1.5]
    base = rist.Model(MODELS / "planar2r_vertical.yaml").base_parameters
    assert base["ZZR1"] == "ZZR1 = ZZ1 + IA1 + L1^2*M2" == base.to_dict()["ZZR1"] and list(base) == base.names
    assert base == rist.Model(MODELS / "planar2r_vertical.yaml").base_parameters != ur5.base_parameters
    with pytest.raises(KeyError, match="did you mean `ZZR1`"):
        base["ZZR3"]


def test_everything_becomes_a_dict(estimate, motion):
    import json

    validation, verdict = rist.validate(URDF, estimate, OTHER)
    check = rist.doctor(URDF, LOG)
    for thing in (estimate, validation, verdict, check, motion, estimate.model):
        values = thing.to_dict()
        # Dicts, lists, texts and numbers: what a file of JSON takes.
        assert json.loads(json.dumps(values)) == values and len(values) > 3, thing
    assert len(estimate.to_dict()["parameters"]) == len(estimate)
    assert validation.to_dict()["total"] == validation.total and verdict.to_dict()["trust"] == verdict.trust
    assert check.joints["coordinate"] == estimate.model.coordinates


def test_equal_is_what_says_the_same(estimate, motion):
    validation, verdict = rist.validate(URDF, estimate, OTHER)
    check = rist.doctor(URDF, LOG)
    for thing in (estimate, validation, verdict, check, motion, estimate.model, estimate.model.base_parameters):
        copy = pickle.loads(pickle.dumps(thing))
        assert copy == thing and hash(copy) == hash(thing) and thing != 3 and not thing != copy
    others = rist.validate(URDF, estimate, LOG)
    assert others[0] != validation and others[1] != verdict and rist.doctor(URDF, OTHER) != check
    assert rist.identify(URDF, OTHER) != estimate


def test_what_is_not_to_be_trusted_is_a_warning(ur5, recwarn):
    log = log_of(ur5)
    wrong = dict(log, tau=-log["tau"])
    with pytest.warns(rist.TrustWarning, match="not to be trusted: .*; next: ") as caught:
        estimate = rist.identify(ur5, wrong)
    assert estimate.verdict.trust == "no" and issubclass(rist.TrustWarning, UserWarning)
    # It points to the line that asked.
    assert caught[0].filename == __file__
    with pytest.warns(rist.TrustWarning):
        rist.validate(ur5, rist.identify(URDF, LOG), wrong)
    with warnings.catch_warnings():
        warnings.simplefilter("error", rist.TrustWarning)
        assert rist.identify(URDF, LOG).verdict.trust == "yes"
        with pytest.raises(rist.TrustWarning):
            rist.identify(ur5, wrong)


def test_a_simulation_says_what_it_assumed_and_warns_of_nothing(motion):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        truth, _ = rist.simulate(URDF, motion, validation=0)
    assert len(truth.notes) > 3 and any("friction" in note for note in truth.notes)
    assert pickle.loads(pickle.dumps(truth)).notes == truth.notes
    # A flag of the program would help nobody here.
    assert not any("--" in note for note in truth.notes), truth.notes
    with pytest.warns(UserWarning) as caught:
        rist.plan(URDF, experiments=8, starts=1, configurations=3)
    assert len(caught) == 1


def test_plots_are_axes_or_pictures(estimate, motion, has_matplotlib, tmp_path):
    validation, _ = rist.validate(URDF, estimate, OTHER)
    check = rist.doctor(URDF, LOG)
    for thing in (estimate, motion, validation, check):
        drawn = thing.plot()
        if not has_matplotlib:
            assert type(drawn) is rist.Picture and "data:image/svg+xml;base64," in drawn._repr_html_()
            drawn.save(tmp_path / "charts")
            assert sorted(drawn.charts) == sorted(path.name for path in (tmp_path / "charts").iterdir())
            for path in (tmp_path / "charts").iterdir():
                path.unlink()
            continue
        assert len(drawn) and all(axis.lines or axis.patches for axis in drawn)
    if has_matplotlib:
        # The lines are the numbers that predict gives.
        axes, series = estimate.plot(OTHER), estimate.predict(OTHER)
        assert len(axes) == 6
        for k, axis in enumerate(axes):
            np.testing.assert_array_equal(axis.lines[0].get_ydata(), series["measured"][:, k])
            np.testing.assert_array_equal(axis.lines[1].get_ydata(), series["predicted"][:, k])
        assert [bar.get_width() for bar in check.plot()[0].patches] == check.joints["slope"]


def page_in(html):
    """The page in the frame."""
    import html as escapes

    [page] = re.findall(r'srcdoc="([^"]*)"', html)
    return escapes.unescape(page)


def test_a_notebook_shows_the_page(estimate, motion, ur5, tmp_path, monkeypatch):
    estimate.report(tmp_path / "page.html")
    page = (tmp_path / "page.html").read_text()
    # It speaks of functions, and of a file for simulators only where bodies were asked for.
    assert "model.generate(estimate=estimate)" in page and "rist generate" not in page and "estimate.write_urdf" not in page
    assert page_in(estimate._repr_html_()) == page and 'sandbox="allow-scripts' in estimate._repr_html_()
    motion.report(tmp_path / "motion.html")
    assert page_in(motion._repr_html_()) == (tmp_path / "motion.html").read_text()
    ur5.report(tmp_path / "model.html")
    assert page_in(ur5._repr_html_()) == (tmp_path / "model.html").read_text()
    validation, _ = rist.validate(URDF, estimate, OTHER)
    validation.report(tmp_path / "validation.html")
    assert page_in(validation._repr_html_()) == (tmp_path / "validation.html").read_text()
    # Torques are drawn of logs that are there: more is drawn than of an estimate out of its file alone.
    estimate.save(tmp_path / "estimate.yaml")
    alone = rist.Estimate.read(tmp_path / "estimate.yaml")
    alone.report(tmp_path / "alone.html")
    assert page.count("<svg") > (tmp_path / "alone.html").read_text().count("<svg")
    with pytest.raises(rist.Error, match="read without its model"):
        alone.report(tmp_path / "alone.html", log=OTHER)
    # A log that is gone is no error of a page that nobody asked it for; a plot asks for it.
    (tmp_path / "gone.csv").write_bytes(LOG.read_bytes())
    gone = rist.identify(URDF, tmp_path / "gone.csv")
    (tmp_path / "gone.csv").unlink()
    assert "<iframe" in gone._repr_html_()
    with pytest.raises(rist.Error, match="gone.csv"):
        gone.predict()
    copy = pickle.loads(pickle.dumps(gone))
    with pytest.raises(rist.Error, match="is not here.*give one, log="):
        copy.predict()
    assert len(copy.predict(OTHER)["t"]) > 100


def test_a_page_that_is_too_large_stays_out_of_a_notebook(monkeypatch):
    """Parameters of 60 joints with 200 logs by name; whatever the page is, what a notebook keeps is bounded."""
    model = rist.Model(MODELS / "ur5.urdf")
    log = log_of(model, noise=0.02)
    logs = [{**log, "t": log["t"] + 0.0} for _ in range(3)]
    assert len(rist.identify(model, logs[0])._repr_html_()) < 1.3 * (2 << 20)


def test_motions_are_played_and_shown(motion, ur5, tmp_path):
    for end in ("csv", "yaml", "json", "script"):
        motion.write_play(tmp_path / f"motion.{end}")
        assert (tmp_path / f"motion.{end}").stat().st_size > 1000
    assert (tmp_path / "motion.csv").read_text() == motion.trajectory()
    assert "servoj" in (tmp_path / "motion.script").read_text() and "joint_names" in (tmp_path / "motion.json").read_text()
    with pytest.raises(rist.Error, match="the end of the name chooses the format"):
        motion.write_play(tmp_path / "motion.txt")
    motion.save(tmp_path / "motion.yaml")
    read = rist.ExcitingMotion.read(tmp_path / "motion.yaml")
    with pytest.raises(rist.Error, match="give model="):
        read.write_play(tmp_path / "again.csv")
    read.write_play(tmp_path / "again.csv", model=URDF)
    assert (tmp_path / "again.csv").read_bytes() == (tmp_path / "motion.csv").read_bytes()
    read.report(tmp_path / "read.html", model=URDF)
    motion.report(tmp_path / "motion.html")
    read.report(tmp_path / "alone.html")
    for name, said in [("read", "found from the motion and the model"), ("motion", "found from the motion and the model"), ("alone", "The file says: ")]:
        assert said in (tmp_path / f"{name}.html").read_text()


def test_the_play_files_are_those_of_the_program(program, motion, tmp_path):
    flags = ["--period", 5, "--repetitions", 1, "--starts", 1, "--iterations", 5]
    files = [tmp_path / f"theirs.{end}" for end in ("csv", "yaml", "json", "script")]
    done = program("excite", URDF, *flags, *(word for file in files for word in ("--play", file)))
    assert done.returncode == 0, done.stderr
    for file in files:
        motion.write_play(tmp_path / f"ours{file.suffix}")
        assert (tmp_path / f"ours{file.suffix}").read_bytes() == file.read_bytes()


def test_options_and_limits_may_be_dicts(ur5, motion, tmp_path):
    options = {"signal": {"cutoff": 8.0}}
    (tmp_path / "options.yaml").write_text("signal:\n  cutoff: 8.0\n")
    found = rist.identify(URDF, LOG, options=options)
    assert found == rist.identify(URDF, LOG, options=tmp_path / "options.yaml") and found.cutoff == 8.0
    assert rist.doctor(URDF, LOG, options=options) == rist.doctor(URDF, LOG, options=tmp_path / "options.yaml")
    limits = {"all": {"velocity": 0.01}}
    faults = rist.check(ur5, motion, limits=limits)
    assert len(faults) == 6 and all("velocity" in fault for fault in faults)
    rest = rist.excite(ur5, period=5.0, repetitions=1, starts=1, iterations=2, limits={"all": {"velocity": 0.5}})
    assert rist.check(ur5, rest, limits={"all": {"velocity": 0.5}}) == []


def test_gains_of_a_doctor_are_those_of_the_program(ur5):
    """Currents in a log: the gain makes torques of them."""
    log = log_of(ur5)
    gains = dict(zip(ur5.coordinates, [12.0, 11.0, 10.0, 9.0, 8.0, 7.0]))
    currents = {"t": log["t"], "q": log["q"], "dq": log["dq"], "i": log["tau"] / np.array(list(gains.values()))}
    slopes = rist.doctor(ur5, currents, gain=gains).joints["slope"]
    np.testing.assert_allclose(slopes, rist.doctor(ur5, log).joints["slope"], rtol=1e-9)


def test_no_message_speaks_in_flags(ur5, tmp_path):
    """What a notebook reads is spelled as a notebook writes it."""
    log = log_of(ur5)
    short = {name: x[:40] for name, x in log.items()}
    degrees = dict(log, q=np.degrees(log["q"]), dq=np.degrees(log["dq"]))
    said = []
    for case in (degrees, dict(log, tau=-log["tau"]), dict(log, tau=np.roll(log["tau"], 8, axis=0))):
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            estimate, check = rist.identify(ur5, case), rist.doctor(ur5, case)
        said += [str(w.message) for w in caught]
        said += [*estimate.remarks, *estimate.findings, repr(estimate), *check.findings, *check.claims, repr(check)]
    columns = {"time": log["t"], **{f"achse_{k}": log["q"][:, k] for k in range(6)}}
    for case in (short, columns, {"t": log["t"]}, {"t": log["t"], "q": log["q"][:, :5], "tau": log["tau"]}):
        with pytest.raises(rist.Error) as raised:
            rist.identify(ur5, case)
        said.append(str(raised.value))
    flags = [flag for text in said for flag in re.findall(r"(?<!\S)--[a-z][a-z-]+[^\n]{0,40}", text)]
    assert not flags, flags
    commands = [command for text in said for command in re.findall(r"rist (?:doctor|plan|excite|identify|validate|generate)[^\n]{0,30}", text)]
    assert not commands, commands
