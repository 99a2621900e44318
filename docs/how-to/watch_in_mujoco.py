"""Identify a robot in MuJoCo, and let the generated monitor in C watch it there: pushes, loads, and nothing at all.

    python docs/how-to/watch_in_mujoco.py RIST MODEL..

RIST is the program, and a MODEL a description with inertial parameters (models/ur5.yaml). For each robot, MuJoCo runs bodies that
are up to 15 % off the description, with viscous friction, Coulomb friction with a Stribeck peak and a part that grows with the
load, and noise of encoders and torques. Four motions of 60 s are identified with their covariance; observer and payload are generated
as C and compiled, and are called each millisecond. The table has:

    hold     largest change of a joint in 10 s of gravity compensation, deg
    alarms   contacts and loads in QUIET seconds of motion without any
    2 5 10   share of the pushes found that make 2, 5, 10 N m at the most loaded joint; in brackets within 20 ms
    side     share of the found pushes of which the last significant joint moves the touched link
    mass     RMS error of loads from 1 to 3 kg, %; in brackets the share of loads that were found
    centre   RMS error of their centre of mass, mm

Needs mujoco, numpy and a C compiler.
"""

import ctypes
import pathlib
import re
import subprocess
import sys
import tempfile

import mujoco
import numpy

STEP, SUBSTEPS, W = 1e-3, 4, 10.0
QUIET, PUSHES, LOADS = 600.0, 40, 8
# The noise of the observer contains errors of the model, which depend on the posture. One motion shows too few of them.
MOTIONS = [1, 3, 4, 5]


def run(*arguments, may_fail=False):
    done = subprocess.run([str(a) for a in arguments], capture_output=True, text=True)
    if done.returncode != 0 and not may_fail:
        sys.exit(f"{' '.join(map(str, arguments))}: {done.stderr}")


class Robot:
    """A robot in MuJoCo, with friction and noise."""

    def __init__(self, urdf, random):
        text = re.sub(r"<(visual|collision)>.*?</\1>", "", urdf.read_text(), flags=re.S)
        options = '<mujoco><compiler balanceinertia="false" boundmass="0" boundinertia="0"/></mujoco>'
        self.model = model = mujoco.MjModel.from_xml_string(re.sub(r"(<robot[^>]*>)", rf"\1{options}", text, count=1))
        self.n, self.random = model.nv, random
        self.names = [model.joint(k).name for k in range(model.njnt)]
        model.jnt_limited[:] = 0
        model.opt.timestep, model.opt.integrator = STEP / SUBSTEPS, mujoco.mjtIntegrator.mjINT_IMPLICITFAST
        self.inertia, self.weight = self.size()
        scale = random.uniform(0.85, 1.15, model.nbody)
        model.body_mass[:] *= scale
        model.body_inertia[:] *= scale[:, None]
        model.body_ipos[:] *= random.uniform(0.85, 1.15, model.nbody)[:, None]
        self.coulomb = 0.05 * self.weight.max() * (self.inertia / self.inertia.max()) ** 0.5
        model.dof_damping[:] = self.coulomb
        self.body = model.jnt_bodyid[-1]
        self.plain = model.body_mass[self.body], model.body_ipos[self.body].copy(), self.tensor()

    def size(self):
        """Diagonal of the inertia matrix, and the torques of gravity, at one posture."""
        data, full = mujoco.MjData(self.model), numpy.zeros((self.n, self.n))
        data.qpos[:] = 0.3
        mujoco.mj_forward(self.model, data)
        for k in range(self.n):
            mujoco.mj_mulM(self.model, data, full[k], numpy.eye(self.n)[k])
        return numpy.diag(full).copy(), numpy.abs(data.qfrc_bias)

    def tensor(self):
        """Inertia of the last body about its centre of mass, in its frame."""
        turn = numpy.zeros(9)
        mujoco.mju_quat2Mat(turn, self.model.body_iquat[self.body])
        turn = turn.reshape(3, 3)
        return turn @ numpy.diag(self.model.body_inertia[self.body]) @ turn.T

    def carry(self, mass, centre):
        """Fixes a ball of 60 mm to the last body; mass 0 takes it away."""
        m, c, tensor = self.plain
        whole = m + mass
        about = (m * c + mass * centre) / whole
        for part, place in ((m, c), (mass, centre)):
            d = place - about
            tensor = tensor + part * (d @ d * numpy.eye(3) - numpy.outer(d, d))
        tensor = tensor + 0.4 * mass * 0.03**2 * numpy.eye(3)
        values, axes = numpy.linalg.eigh(tensor)
        axes[:, 0] *= numpy.sign(numpy.linalg.det(axes))
        model = self.model
        model.body_mass[self.body], model.body_ipos[self.body], model.body_inertia[self.body] = whole, about, values
        mujoco.mju_mat2Quat(model.body_iquat[self.body], axes.reshape(9))

    def run(self, motion, law, happen=None, watch=None):
        """Follows a motion. happen(t, data) may push; watch(t, q, dq, tau) sees the measured state. Returns the log."""
        model, data = self.model, mujoco.MjData(self.model)
        data.qpos[:], data.qvel[:] = motion[0][0], motion[1][0]
        mujoco.mj_forward(model, data)
        waiting, rows, normal = [law(data.qpos, data.qvel, *(x[0] for x in motion))], [], self.random.normal
        before = waiting[0]
        for k, asked in enumerate(zip(*motion)):
            q = data.qpos + normal(scale=1e-5, size=self.n)
            dq = data.qvel + normal(scale=5e-4, size=self.n)
            waiting.append(law(q, dq, *asked))
            torque = waiting.pop(0)
            # A torque is held over the millisecond after its sample: the mean of two is measured.
            tau, before = (torque + before) / 2 + normal(scale=0.01 * self.coulomb + 0.02, size=self.n), torque
            # Friction: a Stribeck peak of 30 % below 0.05 rad/s, and 3 % of the load.
            peak = 1 + 0.3 * numpy.exp(-((data.qvel / 0.05) ** 2))
            model.dof_frictionloss[:] = self.coulomb * peak + 0.03 * numpy.abs(data.qfrc_bias)
            data.qfrc_applied[:] = torque
            data.xfrc_applied[:] = 0
            if happen:
                happen(k * STEP, data)
            for _ in range(SUBSTEPS):
                mujoco.mj_step(model, data)
            if watch:
                watch(k * STEP, q, dq, tau)
            rows.append(numpy.concatenate([[k * STEP], q, dq, tau]))
        return numpy.array(rows)

    def motion(self, seconds, seed, pauses=False):
        """Sines with reversals of each joint, fast and slow: positions, velocities and accelerations."""
        random = numpy.random.default_rng(seed)
        t = STEP * numpy.arange(int(seconds / STEP))[:, None]
        found = [numpy.zeros((len(t), self.n)) for _ in range(3)]
        for _ in range(4):
            a, w, p = random.uniform(0.1, 0.35, self.n), random.uniform(0.3, 2.5, self.n), random.uniform(0, 6.3, self.n)
            found[0] += a * numpy.sin(w * t + p)
            found[1] += a * w * numpy.cos(w * t + p)
            found[2] -= a * w * w * numpy.sin(w * t + p)
        return found

    def stiff(self, q, dq, q_r, dq_r, ddq_r):
        return self.inertia * (ddq_r + 9 * W * W * (q_r - q) + 6 * W * (dq_r - dq))


SHIM = """
#include <math.h>
#include "arm.h"
static {p}_monitor m;
void start(void) {{ {p}_start(&m); }}
int step(const double *q, const double *dq, const double *tau, double period, double *ratio, double *load, int *last)
{{
    int k, status = {p}_monitor_step(&m, q, dq, tau, period);
    *ratio = 0;
    for (k = 0; k < {n}; k++)
        *ratio = fmax(*ratio, fabs(m.beyond[k]) / m.limit[k]);
    for (k = 0; k < 10; k++)
        load[k] = m.load.parameters[k];
    *last = m.load.last_joint;
    return status;
}}
"""


class Monitor:
    """The generated monitor."""

    def __init__(self, rist, urdf, here, n):
        run(rist, "generate", urdf, "--functions", "observer,payload", "--estimate", here / "estimate.yaml", "--anyway",
            "--rate", 1 / STEP, "--language", "c", "--out", here / "arm")
        prefix = re.search(r"(\w+)_start\(", (here / "arm.h").read_text()).group(1)
        self.contact, self.load_changed = (
            int(re.search(rf"#define {prefix.upper()}_{name} (\d+)", (here / "arm.h").read_text()).group(1))
            for name in ("CONTACT", "LOAD_CHANGED")
        )
        (here / "shim.c").write_text(SHIM.format(p=prefix, n=n))
        run("cc", "-O2", "-std=c99", "-shared", "-fPIC", "-o", here / "shim.so", here / "shim.c", here / "arm.c", "-lm")
        self.library = ctypes.CDLL(str(here / "shim.so"))
        self.ratio, self.parameters, self.last = ctypes.c_double(), numpy.zeros(10), ctypes.c_int()

    def begin(self):
        self.library.start()
        self.contacts, self.loads, self.before = [], [], 0

    def __call__(self, t, q, dq, tau):
        numbers = lambda x: numpy.ascontiguousarray(x, dtype=float).ctypes.data_as(ctypes.c_void_p)
        held = [numpy.ascontiguousarray(x, dtype=float) for x in (q, dq, tau)]
        status = self.library.step(*map(numbers, held), ctypes.c_double(STEP), ctypes.byref(self.ratio),
                                   numbers(self.parameters), ctypes.byref(self.last))
        if status & self.contact and not self.before & self.contact:
            self.contacts.append([t, 0.0, 0])
        if status & self.contact and self.ratio.value > self.contacts[-1][1]:
            self.contacts[-1][1:] = self.ratio.value, self.last.value
        if status & self.load_changed:
            self.loads.append(t)
        self.before = status


def pushes(robot, watch, law, size):
    """Shares of pushes: found, found within 20 ms, on the right side."""
    random = numpy.random.default_rng(int(size) + 50)
    bodies = [robot.model.jnt_bodyid[k] for k in range(robot.n)]
    plan = [(4.0 * (i + 1) + random.uniform(), random.integers(1, robot.n), random.normal(size=3)) for i in range(PUSHES)]
    jacobian, found = numpy.zeros((3, robot.n)), []

    def happen(t, data):
        for at, link, force in plan:
            if at <= t < at + 0.3:
                body = bodies[link]
                place = data.xpos[body] + data.xmat[body].reshape(3, 3) @ [0.1, 0.1, 0.1]
                mujoco.mj_jac(robot.model, data, jacobian, None, place, body)
                torque = jacobian.T @ force
                scale = size / max(numpy.abs(torque).max(), 1e-9)
                data.xfrc_applied[body, :3] = scale * force
                data.xfrc_applied[body, 3:] = numpy.cross(place - data.xipos[body], scale * force)

    watch.begin()
    robot.run(robot.motion(4.0 * (PUSHES + 2), 7 + int(size)), law, happen, watch)
    for at, link, _ in plan:
        hit = [c for c in watch.contacts if at <= c[0] < at + 0.35]
        found.append((bool(hit), bool(hit) and hit[0][0] <= at + 0.02, bool(hit) and hit[0][2] <= link))
    found = numpy.array(found, dtype=float)
    return found[:, 0].mean(), found[:, 1].mean(), found[:, 2].sum() / max(found[:, 0].sum(), 1)


def loads(robot, watch, law):
    """Relative RMS error of the mass, RMS error of the centre, m, and the share of the loads that were found."""
    random, errors, centres = numpy.random.default_rng(3), [], []
    for draw in range(LOADS):
        mass, centre = random.uniform(1, 3), random.uniform(-0.06, 0.06, 3)
        is_on = []

        def happen(t, _data):
            if t >= 5.0 and not is_on:
                is_on.append(robot.carry(mass, centre))

        watch.begin()
        robot.run(robot.motion(14.0, 90 + draw), law, happen, watch)
        robot.carry(0.0, numpy.zeros(3))
        if watch.loads:
            errors.append(watch.parameters[9] / mass - 1)
            centres.append(numpy.linalg.norm(watch.parameters[6:9] / watch.parameters[9] - centre) / 3**0.5)
    rms = lambda x: numpy.sqrt(numpy.mean(numpy.square(x))) if x else numpy.nan
    return rms(errors), rms(centres), len(errors) / LOADS


def robot_of(rist, path, here):
    urdf = here / "robot.urdf"
    if path.suffix == ".urdf":
        urdf.write_text(path.read_text())
    else:
        run(rist, "convert", path, "--to", "urdf", "--out", urdf)
    return urdf, Robot(urdf, numpy.random.default_rng(11))


def hold(robot, rist, urdf, here):
    """Largest change of a joint in 10 s of gravity compensation, deg."""
    source = here / "gravity.c"
    run(rist, "generate", urdf, "--functions", "controller", "--estimate", here / "estimate.yaml", "--anyway", "--language", "c",
        "--out", source)
    run("cc", "-O2", "-shared", "-fPIC", "-o", here / "gravity.so", source, "-lm")
    library = ctypes.CDLL(str(here / "gravity.so"))
    prefix = re.search(r"int (\w+)_gravity_compensation\(", source.read_text()).group(1)
    function = getattr(library, f"{prefix}_gravity_compensation")
    numbers = lambda x: x.ctypes.data_as(ctypes.c_void_p)
    of_file = lambda name: ctypes.c_void_p(ctypes.addressof(ctypes.c_double.in_dll(library, f"{prefix}_{name}")))
    limit = 1e6 * numpy.ones(robot.n)

    def law(q, *_):
        held, tau = numpy.ascontiguousarray(q, dtype=float), numpy.zeros(robot.n)
        function(numbers(held), of_file("x"), numbers(limit), numbers(tau))
        return tau

    still = [numpy.full((10000, robot.n), 0.3), numpy.zeros((10000, robot.n)), numpy.zeros((10000, robot.n))]
    # Friction of MuJoCo is soft, so a joint at rest creeps under any torque. These iterations hold it, as dry friction does.
    robot.model.opt.noslip_iterations = 20
    log = robot.run(still, law)
    robot.model.opt.noslip_iterations = 0
    return numpy.degrees(numpy.abs(log[:, 1 : 1 + robot.n] - 0.3).max())


def judged(rist, path, here):
    urdf, robot = robot_of(rist, path, here)
    law = robot.stiff
    header = ",".join(["t", *(f"{x}_{name}" for x in ("q", "dq", "tau") for name in robot.names)])
    logs = [here / f"log{k}.csv" for k in MOTIONS]
    for k, log in zip(MOTIONS, logs):
        numpy.savetxt(log, robot.run(robot.motion(60.0, k), law)[::2], delimiter=",", header=header, comments="")
    # A verdict of no is exit code 1; the table is the judge here.
    run(rist, "identify", urdf, *logs, "--covariance", "--out", here / "estimate.yaml", may_fail=True)
    watch = Monitor(rist, urdf, here, robot.n)
    still = hold(robot, rist, urdf, here)
    watch.begin()
    robot.run(robot.motion(QUIET, 2), law, watch=watch)
    alarms = len(watch.contacts) + len(watch.loads)
    found = [pushes(robot, watch, law, size) for size in (2.0, 5.0, 10.0)]
    mass, centre, share = loads(robot, watch, law)
    shares = "  ".join(f"{100 * all_of:3.0f} % ({100 * quick:3.0f} %)" for all_of, quick, _ in found)
    print(f"{path.stem:<10} {still:5.2f} {alarms:6d}  {shares}  {100 * found[-1][2]:4.0f} %  {100 * mass:5.1f} % ({100 * share:3.0f} %) "
          f"{1e3 * centre:6.1f}", flush=True)


print(f"{'robot':<10} {'hold':>5} {'alarms':>6}  {'2 N m':>14} {'5 N m':>14} {'10 N m':>14}   side   mass          centre")
for path in map(pathlib.Path, sys.argv[2:]):
    with tempfile.TemporaryDirectory() as folder:
        judged(pathlib.Path(sys.argv[1]).resolve(), path.resolve(), pathlib.Path(folder))
