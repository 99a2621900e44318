"""Sums over logs: merged they are one pass, they pickle, and the recipe of docs/how-to/python.md runs on a fleet."""

import os
import pickle
import sys

import numpy as np
import pytest

import rist
from conftest import ROOT, log_of, write_csv


EXAMPLES = ROOT / "crates/python/examples"


@pytest.fixture(scope="module")
def model():
    return rist.Model.read(ROOT / "tests/data/robots/planar2r_vertical.yaml")


# A two-link arm of links of 4 and 2 kg.
PARAMETERS = [1.2, 2.0, 0.1, 0.3, 0.5, 0.05, 0.2]


@pytest.fixture(scope="module")
def logs(model):
    return [log_of(model, PARAMETERS, seed=seed) for seed in range(1, 6)]


def test_merged_is_one_pass(model, logs):
    # A log is named by the table it came from: each in a list has a number.
    whole = rist.Accumulator(model, cutoff=10.0).update(logs)
    parts = [rist.Accumulator(model, cutoff=10.0).update(logs[:2]), rist.Accumulator(model, cutoff=10.0).update(logs[2:])]
    merged = pickle.loads(pickle.dumps(parts[1])).merge(parts[0])
    assert len(merged) == len(whole) == 5 and merged.samples == whole.samples
    # 1e-12 of the largest: an offset that is zero has no digits of its own.
    np.testing.assert_allclose(merged.solve().values, whole.solve().values, rtol=0, atol=1e-12 * np.abs(whole.solve().values).max())
    expected = rist.identify(model, logs, cutoff=10.0, weights="joint")
    np.testing.assert_allclose(merged.solve().values, expected.values, rtol=0, atol=1e-11 * np.abs(expected.values).max())
    with pytest.raises(rist.Error, match="same log|both|already"):
        merged.merge(parts[0])
    with pytest.raises(rist.Error):
        merged.merge(merged)
    with pytest.raises(rist.Error):
        merged.merge(rist.Accumulator(model, cutoff=8.0).update(logs[:1]))
    assert len(merged) == 5


def test_refusals(model, logs, ur5, tmp_path):
    with pytest.raises(rist.Error, match="cutoff= is missing"):
        rist.Accumulator(model)
    with pytest.raises(rist.Error, match="no option `cutof`"):
        rist.Accumulator(model, cutof=3)
    with pytest.raises(rist.Error, match="sums have no rows"):
        rist.Accumulator(model, cutoff=10.0, friction="auto")
    sums = rist.Accumulator(model, cutoff=10.0).update(logs[0])
    with pytest.raises(rist.Error):
        sums.update({"t": [0.0, 1.0], "q": [[0, 0], [0, 0]]})
    assert len(sums) == 1 and "1 logs" in repr(sums)
    sums.save(tmp_path / "sums.tri")
    assert rist.Accumulator.read(tmp_path / "sums.tri", model).to_bytes() == sums.to_bytes()
    with pytest.raises(rist.Error, match="this model is"):
        rist.Accumulator.read(tmp_path / "sums.tri", ur5)
    sums.fail("broken.csv", "cut short")
    assert sums.failed == [("broken.csv", "cut short")]
    assert any("broken.csv" in remark for remark in sums.solve().remarks)


def test_what_changed(model):
    heavy = np.array(PARAMETERS) + np.array([0, 0, 0, 0.02, 0.06, 0, 0])
    of = lambda x, seeds: rist.Accumulator(model, cutoff=10.0).update([log_of(model, x, seed=s) for s in seeds])
    reference = of(PARAMETERS, range(1, 7))
    found = rist.compare(reference, {"same": of(PARAMETERS, range(11, 17)), "heavy": of(heavy, range(21, 27))})
    assert found.changed == ["heavy"]
    difference, sigma = found.moved["heavy"]["MX2"]
    # Five deviations of an estimate whose truth is known.
    assert abs(difference - 0.06) < 5 * sigma
    assert pickle.loads(pickle.dumps(found)).changed == ["heavy"]


@pytest.fixture(scope="module")
def fleet(model, tmp_path_factory):
    """Three robots of four logs each; one log of r2 is cut short, one of r3 is another robot's."""
    folder = tmp_path_factory.mktemp("fleet")
    for robot in range(1, 4):
        (folder / f"r{robot}").mkdir()
        for day in range(1, 5):
            x = np.array(PARAMETERS) * (1 + 0.1 * robot)
            log = log_of(model, x, seed=10 * robot + day)
            write_csv(log, folder / f"r{robot}" / f"day{day}.csv")
    broken = folder / "r2" / "day3.csv"
    broken.write_bytes(broken.read_bytes()[:150])
    (folder / "r3" / "day1.csv").write_text("t,speed\n0,1\n1,2\n")
    return folder


def check(fleet, model, estimates):
    """One estimate a robot, right, and saying what it lacks."""
    assert sorted(estimates) == ["r1", "r2", "r3"]
    for name, estimate in estimates.items():
        truth = np.array(PARAMETERS) * (1 + 0.1 * int(name[1:]))
        # Friction at reversals is filtered: two per cent of the largest.
        np.testing.assert_allclose(estimate.values[: len(truth)], truth, atol=0.02 * truth.max())
        lacks = " ".join(remark for remark in estimate.remarks if remark.startswith("not in it: "))
        assert ("day3.csv" in lacks) == (name == "r2") and ("day1.csv" in lacks) == (name == "r3"), lacks


@pytest.fixture(scope="module")
def recipe():
    sys.path.insert(0, str(EXAMPLES))
    import fleet as module

    return module


def test_the_recipe_on_threads(recipe, fleet, model):
    check(fleet, model, recipe.on_threads(ROOT / "tests/data/robots/planar2r_vertical.yaml", fleet, cutoff=10.0))


def test_a_worker_that_is_killed_is_replaced(recipe, fleet, model, tmp_path, monkeypatch):
    """The first worker that comes to r1/day2.csv is killed, as by a machine out of memory; the log is read by another."""
    monkeypatch.setenv("RIST_EXAMPLE_KILL", str(tmp_path / "killed"))
    estimates = recipe.on_processes(ROOT / "tests/data/robots/planar2r_vertical.yaml", fleet, cutoff=10.0, workers=2)
    assert (tmp_path / "killed").exists()
    check(fleet, model, estimates)


def test_the_recipe_on_daft(recipe, fleet, model):
    pytest.importorskip("daft", reason="daft is not installed")
    check(fleet, model, recipe.on_daft(ROOT / "tests/data/robots/planar2r_vertical.yaml", fleet, cutoff=10.0))


def test_the_recipe_on_ray(recipe, fleet, model, tmp_path, monkeypatch):
    """Here too the first worker that comes to r1/day2.csv is killed."""
    ray = pytest.importorskip("ray", reason="ray is not installed")
    monkeypatch.setenv("RIST_EXAMPLE_KILL", str(tmp_path / "killed"))
    # Workers import the recipe by its name.
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(EXAMPLES), os.environ.get("PYTHONPATH", "")]))
    ray.init(num_cpus=2, include_dashboard=False)
    try:
        check(fleet, model, recipe.on_ray(ROOT / "tests/data/robots/planar2r_vertical.yaml", fleet, cutoff=10.0))
    finally:
        ray.shutdown()
    assert (tmp_path / "killed").exists()
