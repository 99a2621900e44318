"""W of a million Panda states: rist from Python, the library alone, Pinocchio's loop and FIGAROH's, in one run.

Seconds are of processor time, and the best of three.

python observation_matrix.py RUST_EXAMPLE RIST_PROGRAM [STATES]
"""

import pathlib
import subprocess
import sys
import tempfile
import time
import types

import numpy as np

import rist

MODEL = pathlib.Path(__file__).resolve().parents[3] / "models/panda.yaml"


def best(call, runs=3):
    seconds = []
    for _ in range(runs):
        start = time.thread_time()
        call()
        seconds.append(time.thread_time() - start)
    return min(seconds)


def pinocchio_model(program):
    """The robot as Pinocchio reads it."""
    import pinocchio

    with tempfile.TemporaryDirectory() as folder:
        urdf = pathlib.Path(folder) / "panda.urdf"
        urdf.write_text(subprocess.run([program, "convert", MODEL, "--to", "urdf"], check=True, capture_output=True, text=True).stdout)
        return pinocchio.buildModelFromUrdf(str(urdf))


def pinocchio_loop(program, q, dq, ddq):
    """Seconds a state of computeJointTorqueRegressor in a loop, its results copied into one array."""
    import pinocchio

    model = pinocchio_model(program)
    data, n = model.createData(), model.nv
    w = np.empty((len(q), n, 10 * n))

    def loop():
        for k in range(len(q)):
            w[k] = pinocchio.computeJointTorqueRegressor(model, data, q[k], dq[k], ddq[k])

    return best(loop) / len(q)


def figaroh_loop(program, q, dq, ddq):
    """Seconds a state of FIGAROH's regressor, without friction and rotor columns."""
    from figaroh.tools.regressor import RegressorBuilder

    model = pinocchio_model(program)
    builder = RegressorBuilder(types.SimpleNamespace(model=model, data=model.createData()))
    every = {"act_idxv": list(range(model.nv))}
    return best(lambda: builder.build_basic_regressor(q, dq, ddq, every), 1) / len(q)


def main(rust, program, count=1_000_000):
    model = rist.Model.read(MODEL)
    states = np.random.default_rng(1).normal(size=(3, int(count), 7))
    rows = [("the library", float(subprocess.run([rust, MODEL, str(count)], check=True, capture_output=True, text=True).stdout))]
    rows.append(("rist.Model.base_regressor", best(lambda: model.base_regressor(*states))))
    rows.append(("rist.Model.regressor (standard, by tape)", best(lambda: model.regressor(*states), 1)))
    few = states[:, : int(count) // 20]
    for what, package, loop in [
        ("Pinocchio's loop (standard)", "pin", pinocchio_loop),
        ("FIGAROH's regressor (standard)", "figaroh", figaroh_loop),
    ]:
        try:
            rows.append((what, loop(program, *few) * int(count)))
        except ImportError:
            print(f"{what}: not installed (pip install {package})")
    for what, seconds in rows:
        print(f"{what:<42} {seconds:8.3f} s  {seconds / rows[0][1]:6.2f}")


if __name__ == "__main__":
    main(*sys.argv[1:])
