"""Identify a robot in MuJoCo, and control it there with the code that rist writes of the estimate.

    python docs/how-to/controller_in_mujoco.py RIST MODEL..

RIST is the program, and a MODEL a description with inertial parameters (models/ur5.yaml). For each robot:
MuJoCo runs it as a URDF, with friction that the URDF does not have; a log of it is identified; the controller with these
numbers is generated as C and compiled; and a motion that was not in the log is followed twice, each millisecond and with a
millisecond of delay: by a PD of 10 rad/s with damping 1, and by computed torque of the same bandwidth. Needs mujoco, numpy
and a C compiler. Exits with 1 where computed torque is not five times as good, or a torque is beyond its limit.
"""

import ctypes
import pathlib
import re
import subprocess
import sys
import tempfile

import mujoco
import numpy

W, STEP, SUBSTEPS, WIDTH = 10.0, 1e-3, 4, 0.02


def run(*arguments, may_fail=False):
    done = subprocess.run([str(a) for a in arguments], capture_output=True, text=True)
    if done.returncode != 0 and not may_fail:
        sys.exit(f"{' '.join(map(str, arguments))}: {done.stderr}")


def sines(count, n, amplitude, slow):
    """Positions, velocities and accelerations that begin at rest."""
    t = STEP * numpy.arange(count)[:, None]
    w = slow + 0.45 * numpy.arange(n)
    size = amplitude * numpy.ones(n)
    first = size * (1 - numpy.cos(w * t)), size * w * numpy.sin(w * t), size * w * w * numpy.cos(w * t)
    u = 2.3 * w
    more = [0.3 * x for x in (size * (1 - numpy.cos(u * t)), size * u * numpy.sin(u * t), size * u * u * numpy.cos(u * t))]
    return [a + b for a, b in zip(first, more)]


def played(model, motion, law, delay):
    """What a law of control makes of a motion: positions, velocities, torques."""
    data = mujoco.MjData(model)
    data.qpos[:], data.qvel[:] = motion[0][0], motion[1][0]
    mujoco.mj_forward(model, data)
    q, dq, torques = [], [], []
    waiting = [law(data.qpos, data.qvel, *(x[0] for x in motion))] * delay
    for asked in zip(*motion):
        waiting.append(law(data.qpos.copy(), data.qvel.copy(), *asked))
        torque = waiting.pop(0)
        q.append(data.qpos.copy()), dq.append(data.qvel.copy()), torques.append(torque)
        data.qfrc_applied[:] = torque
        for _ in range(SUBSTEPS):
            mujoco.mj_step(model, data)
    return map(numpy.array, (q, dq, torques))


def robot(rist, path, here):
    urdf = here / "robot.urdf"
    if path.suffix == ".urdf":
        urdf.write_text(path.read_text())
    else:
        run(rist, "convert", path, "--to", "urdf", "--out", urdf)
    text = re.sub(r"<(visual|collision)>.*?</\1>", "", urdf.read_text(), flags=re.S)
    options = '<mujoco><compiler balanceinertia="false" boundmass="0" boundinertia="0"/></mujoco>'
    model = mujoco.MjModel.from_xml_string(re.sub(r"(<robot[^>]*>)", rf"\1{options}", text, count=1))
    n, names = model.nv, [model.joint(k).name for k in range(model.njnt)]
    model.jnt_limited[:] = 0
    model.opt.timestep, model.opt.integrator = STEP / SUBSTEPS, mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    data, inertia = mujoco.MjData(model), numpy.zeros((n, n))
    data.qpos[:] = 0.3
    mujoco.mj_forward(model, data)
    for k in range(n):
        mujoco.mj_mulM(model, data, inertia[k], numpy.eye(n)[k])
    inertia, weight = numpy.diag(inertia).copy(), numpy.abs(data.qfrc_bias)
    model.dof_damping[:], model.dof_frictionloss[:] = inertia, 2 * inertia
    limit = 60 * inertia + 2 * weight + 5

    def pd(q, dq, q_r, dq_r, ddq_r):
        return numpy.clip(inertia * (W * W * (q_r - q) + 2 * W * (dq_r - dq)), -limit, limit)

    def stiff(q, dq, q_r, dq_r, ddq_r):
        return inertia * (W * W * 9 * (q_r - q) + 6 * W * (dq_r - dq))

    q, dq, tau = played(model, sines(12000, n, 0.7, 1.4), stiff, 0)
    # A torque is held over the millisecond after its sample: the log has the mean of two.
    tau[1:] = (tau[1:] + tau[:-1]) / 2
    noise = numpy.random.default_rng(1).normal
    columns = [q + noise(scale=1e-5, size=q.shape), dq, tau + noise(scale=0.005 * numpy.abs(tau).max(axis=0), size=q.shape)]
    table = numpy.hstack([STEP * numpy.arange(len(q))[:, None], *columns])[::2]
    header = ",".join(["t", *(f"{x}_{name}" for x in ("q", "dq", "tau") for name in names)])
    numpy.savetxt(here / "log.csv", table, delimiter=",", header=header, comments="")

    # A verdict of no is exit code 1; the loop below is the judge here.
    run(rist, "identify", urdf, here / "log.csv", "--out", here / "estimate.yaml", may_fail=True)
    source = here / "controller.c"
    run(rist, "generate", urdf, "--functions", "controller", "--estimate", here / "estimate.yaml", "--anyway", "--language", "c", "--out", source)
    run("cc", "-O2", "-shared", "-fPIC", "-o", here / "controller.so", source, "-lm")
    library = ctypes.CDLL(str(here / "controller.so"))
    prefix = re.search(r"void (\w+)_inverse_dynamics\(", source.read_text()).group(1)
    computed = getattr(library, f"{prefix}_computed_torque")
    numbers = lambda x: numpy.ascontiguousarray(x, dtype=float).ctypes.data_as(ctypes.c_void_p)
    of_file = lambda name: ctypes.c_void_p(ctypes.addressof(ctypes.c_double.in_dll(library, f"{prefix}_{name}")))
    kp, kd, width = W * W * numpy.ones(n), 2 * W * numpy.ones(n), WIDTH * numpy.ones(n)

    def computed_torque(*state):
        held, tau = [numpy.ascontiguousarray(x, dtype=float) for x in state], numpy.empty(n)
        computed(*map(numbers, [*held, kp, kd]), of_file("x"), of_file("f"), numbers(width), numbers(limit), numbers(tau))
        return tau

    motion = sines(8000, n, 0.4, 2.0)
    found = []
    for law in (pd, computed_torque):
        q, _, tau = played(model, motion, law, 1)
        assert numpy.isfinite(q).all(), "the loop is unstable"
        found.append((numpy.sqrt(numpy.mean((q - motion[0]) ** 2)), numpy.max(numpy.abs(tau) / limit)))
    (alone, _), (with_model, used) = found
    print(
        f"{path.stem:<12} RMS of the PD alone {alone:.2e}, of computed torque {with_model:.2e} rad: "
        f"{alone / with_model:.0f} times as good; {100 * used:.0f} % of the limits"
    )
    return with_model < alone / 5 and used <= 1


good = []
for path in map(pathlib.Path, sys.argv[2:]):
    with tempfile.TemporaryDirectory() as folder:
        good.append(robot(pathlib.Path(sys.argv[1]).resolve(), path.resolve(), pathlib.Path(folder)))
sys.exit(0 if good and all(good) else 1)
