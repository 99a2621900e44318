"""The walk of spectrum analysis, and the exciting motion: the bytes of the program."""

import pickle

import numpy as np
import pytest

import rist
from conftest import MODELS


@pytest.fixture(scope="module")
def planar():
    return rist.Model.read(MODELS / "planar2r_vertical.yaml")


def test_the_walk_is_that_of_the_program(program, tmp_path):
    path = MODELS / "race.yaml"
    race = rist.Model.read(path)
    calls = []
    plan = rist.plan(race, experiments=4, starts=3, configurations=20, progress=lambda *x: calls.append(x))
    assert [x[0] for x in calls] == [1, 2, 3]
    plan.save(tmp_path / "plan.yaml")
    flags = ["--experiments", 4, "--starts", 3, "--configurations", 20]
    program("plan", path, *flags, "--out", tmp_path / "program.yaml")
    assert (tmp_path / "plan.yaml").read_bytes() == (tmp_path / "program.yaml").read_bytes()

    gain = {"q1": 2.393, "q2": 0.870}
    truth, logs = rist.simulate(race, plan, gain=gain, validation=2, out=tmp_path / "logs")
    program("simulate", path, tmp_path / "plan.yaml", "--gain", "q1=2.393,q2=0.870", "--validation", 2, "--out", tmp_path / "theirs")
    names = sorted(p.name for p in (tmp_path / "logs").iterdir())
    assert names == ["e01.csv", "e02.csv", "e03.csv", "e04.csv", "truth.yaml", "v01.csv", "v02.csv"]
    for name in names:
        assert (tmp_path / "logs" / name).read_bytes() == (tmp_path / "theirs" / name).read_bytes(), name
    assert logs["e01"]["q"].shape == logs["e01"]["i"].shape == (len(logs["e01"]["t"]), 3)
    assert truth.parameters["KT1"] == 2.393

    found = rist.identify(race, tmp_path / "logs", method="rist-mh", plan=plan, gain={"q3": 1.0})
    program("identify", path, tmp_path / "logs", "--plan", tmp_path / "plan.yaml", "--method", "rist-mh", "--gain", "q3=1", "--out", tmp_path / "estimate.yaml")
    assert found.to_yaml() == (tmp_path / "estimate.yaml").read_text()
    # Four experiments for eighteen parameters: the gains are determined to a few per cent.
    assert found.parameters["KT1"] == pytest.approx(2.393, rel=0.05)
    motions = sorted((tmp_path / "logs").glob("v*.csv"))
    validation, verdict = rist.validate(race, found, motions)
    assert validation.total < 0.2 and set(validation.logs) == set(map(str, motions))
    assert pickle.loads(pickle.dumps(plan)).to_yaml() == plan.to_yaml()


def test_a_page_of_a_plan_proves_it_as_that_of_the_program(planar, program, tmp_path):
    description = MODELS / "planar2r_vertical.yaml"
    rist.plan(planar, experiments=4, starts=2, configurations=10).save(tmp_path / "plan.yaml")
    read = rist.ExperimentPlan.read(tmp_path / "plan.yaml")

    def page(name, **options):
        read.report(tmp_path / name, **options)
        return (tmp_path / name).read_text()

    program("report", "--plan", tmp_path / "plan.yaml", "--model", description, "--out", tmp_path / "theirs.html")
    theirs = (tmp_path / "theirs.html").read_text()
    proven = page("with.html", model=description)
    for said in ["Found again from the plan and the model: ", "e01: no floor, lowest point "]:
        assert said in proven and said in theirs, said
    assert page("known.html", model=planar) == proven
    without = page("without.html")
    assert "Nobody proved it" in without and "Found again" not in without
    with pytest.raises(rist.Error, match="its geometry or joints have changed"):
        read.report(tmp_path / "other.html", model=MODELS / "race.yaml")


@pytest.fixture(scope="module")
def experiments(planar, tmp_path_factory):
    """The plan, and the directory of its simulated logs."""
    logs = tmp_path_factory.mktemp("effects")
    plan = rist.plan(planar, experiments=4, starts=2, configurations=10)
    plan.save(logs / "plan.yaml")
    rist.simulate(planar, plan, validation=1, out=logs)
    return plan, logs


def test_effects_are_those_of_the_program(planar, experiments, program, tmp_path):
    plan, logs = experiments
    for flags, options in [
        (("--ripple", "q2=12,q2=6"), dict(ripple={"q2": [12, 6]})),
        (("--ripple", "q1=3,q2=12", "--delay", "auto"), dict(ripple={"q1": np.float64(3), "q2": 12}, delay="auto")),
        (("--ripple", "12"), dict(ripple=12, elastic=False, backlash=[])),
        (("--elastic", "q2", "--cutoff", "15"), dict(elastic=["q2"], cutoff=15)),
        (("--elastic", "all"), dict(elastic=True)),
        (("--backlash", "q1"), dict(backlash="q1")),
    ]:
        done = program("identify", MODELS / "planar2r_vertical.yaml", logs, "--plan", logs / "plan.yaml", "--method", "rist-mh", *flags, "--out", tmp_path / "program.yaml")
        found = rist.identify(planar, logs, method="rist-mh", plan=plan, **options)
        assert found.to_yaml() == (tmp_path / "program.yaml").read_text(), (flags, done.stderr)
        assert ("ripple" in options) == any("ripple" in remark for remark in found.remarks), found.remarks


def test_effects_that_cannot_be_are_refused(planar, experiments):
    plan, logs = experiments

    def message(method="rist-mh", **options):
        with pytest.raises(rist.Error) as raised:
            rist.identify(planar, logs, method=method, plan=plan, **options)
        return str(raised.value)

    assert message(ripple={"q9": 12}) == "ripple=: there is no coordinate `q9`; there are q1, q2"
    assert message(elastic=["q9"]) == "elastic=: there is no coordinate `q9`; there are q1, q2"
    assert message(backlash="q9") == "backlash=: there is no coordinate `q9`; there are q1, q2"
    for wrong in (True, "12", {"q2": "12"}, {2: 12}, {"q2": True}):
        assert 'expected is periods a turn of all joints, or of some, as {"q2": 12}' in message(ripple=wrong), wrong
    for wrong in (0, -1, {"q2": [6, 0]}, 1e5):
        assert "a number above 0 and up to 10000 is expected" in message(ripple=wrong), wrong
    for wrong in (2, [1], {"q2": True}, [True]):
        for name in ("elastic", "backlash"):
            said = message(**{name: wrong})
            assert said.startswith(f"identify: {name}= is ") and "true for all joints, or a list" in said, (wrong, said)
    assert message(cutoff=-1.0) == "identify: cutoff= must be a positive number, not -1"
    assert "expected is a number" in message(cutoff=float("nan"))
    assert "seconds between -1 and 1 are expected" in message(delay=2.0)
    for options in (dict(ripple=12), dict(elastic=True), dict(backlash=["q1"])):
        [name] = options
        said = f"identify: {name}=: method='{{}}' does not use that; method='rist-mh' does"
        assert message(method="rist", **options) == said.format("rist")
        for method in ("ls", "essential"):
            with pytest.raises(rist.Error, match=said.format(method)):
                rist.identify(planar, logs / "e01.csv", method=method, **options)


def test_a_motion_is_proven(planar, program, tmp_path):
    options = dict(harmonics=2, starts=1, iterations=5, period=5.0)
    motion = rist.excite(planar, **options)
    program("excite", MODELS / "planar2r_vertical.yaml", "--harmonics", 2, "--starts", 1, "--iterations", 5, "--period", 5, "--out", tmp_path / "motion.yaml")
    assert motion.to_yaml() == (tmp_path / "motion.yaml").read_text()
    assert motion.proven and rist.check(planar, motion) == []
    # A page of a file does not believe the file.
    text = motion.to_yaml()
    first = text.index("centre: ") + len("centre: ")
    changed = rist.ExcitingMotion.from_yaml(text[:first] + "50 #" + text[first:])
    changed.report(tmp_path / "changed.html", model=planar)
    assert "BROKEN: position" in (tmp_path / "changed.html").read_text()
    (tmp_path / "limits.yaml").write_text("all:\n  velocity: 0.01\n")
    faults = rist.check(planar, motion, limits=tmp_path / "limits.yaml")
    assert len(faults) == 2 and all("velocity" in fault for fault in faults)
    with pytest.raises(rist.Error, match="none.yaml"):
        rist.check(planar, motion, limits=tmp_path / "none.yaml")
    assert pickle.loads(pickle.dumps(motion)).to_yaml() == motion.to_yaml()
    played = np.loadtxt(motion.trajectory().splitlines()[1:], delimiter=",")
    assert played.shape[0] > 3 * 5 * 200 and np.isfinite(played).all()
    truth, logs = rist.simulate(planar, motion, validation=1, noise_free=True)
    assert sorted(logs) == ["motion", "v01"]
    first = rist.identify(planar, logs["motion"], covariance=True)
    second = rist.excite(planar, after=first, **options)
    # The information on each parameter includes the information of the first motion.
    assert second.proven and "identified:" in second.to_yaml() and "identified:" not in motion.to_yaml()
    for wrong, said in [(dict(harmonics=0), "harmonics= is 0"), (dict(start=3), r"no option `start` \(did you mean starts=\?\)")]:
        with pytest.raises(rist.Error, match=said):
            rist.excite(planar, **wrong)
