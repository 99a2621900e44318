"""What the tests share: the models of the repository, a robot with a log, the program."""

import os
import pathlib
import subprocess

import numpy as np
import pytest

import rist

ROOT = pathlib.Path(__file__).resolve().parents[3]
MODELS = ROOT / "models"


def motion(model, seconds=8.0, rate=200.0, seed=1):
    """t (N,), q, dq, ddq (N, n) of a sum of sines, different for each joint."""
    random = np.random.default_rng(seed)
    t = np.arange(0.0, seconds, 1.0 / rate)
    n = len(model.coordinates)
    w = 2 * np.pi * random.uniform(0.1, 0.8, (3, n))
    a, phase = random.uniform(0.2, 0.6, (3, n)), random.uniform(0, 6, (3, n))
    angle = w * t[:, None, None] + phase
    return t, *(np.sum(x, axis=1) for x in (a * np.sin(angle), a * w * np.cos(angle), -a * w**2 * np.sin(angle)))


def log_of(model, parameters=None, seed=1, noise=0.02):
    """A log of the motion: t, q, dq and tau with viscous and Coulomb friction."""
    t, q, dq, ddq = motion(model, seed=seed)
    tau = model.torque(q, dq, ddq, parameters) + 2.0 * dq + 1.5 * np.sign(dq)
    tau += noise * np.random.default_rng(seed).normal(size=tau.shape)
    return {"t": t, "q": q, "dq": dq, "tau": tau}


def write_csv(log, path):
    """The arrays as text, every digit of them."""
    names = [f"{key}{k + 1}" for key in ("q", "dq", "tau") for k in range(log[key].shape[1])]
    columns = np.column_stack([log["t"], log["q"], log["dq"], log["tau"]])
    lines = [",".join(["t", *names])] + [",".join(repr(float(x)) for x in row) for row in columns]
    pathlib.Path(path).write_text("\n".join(lines) + "\n")


@pytest.fixture(scope="session")
def panda():
    return rist.Model.read(MODELS / "panda.yaml")


@pytest.fixture(scope="session")
def ur5():
    return rist.Model.read(MODELS / "ur5.urdf")


@pytest.fixture(scope="session")
def log(ur5):
    return log_of(ur5)


@pytest.fixture(scope="session")
def csv(log, tmp_path_factory):
    path = tmp_path_factory.mktemp("logs") / "log.csv"
    write_csv(log, path)
    return path


@pytest.fixture(scope="session")
def program():
    """Runs the program `rist` at the root of the repository."""
    path = os.environ.get("RIST_PROGRAM")
    if not path:
        pytest.skip("RIST_PROGRAM does not say where the program rist is; cargo xtask python says it")

    # Sentences in one line, as Python has them.
    unfolded = {**os.environ, "COLUMNS": "100000"}

    def run(*arguments):
        done = subprocess.run([path, *map(str, arguments)], cwd=ROOT, capture_output=True, text=True, env=unfolded)
        return done

    return run
