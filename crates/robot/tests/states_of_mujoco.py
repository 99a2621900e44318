"""States of MJCF models with the mass matrix and the bias of MuJoCo, as lines of numbers.

    python states_of_mujoco.py list                 models of the installed packages, and of the folders in RIST_MJCF
    python states_of_mujoco.py states FLOATS FILE   n and whether bodies weigh by meshes, then lines of q, dq, M (row by row), bias
    python states_of_mujoco.py run PAIRS            the same for lines `FLOATS FILE` of standard input

FLOATS is 1 where the base floats: the first six coordinates are then x y z yaw pitch roll instead of MuJoCo's.
"""

import glob
import importlib.util
import os
import sys

import numpy as np

import mujoco

PACKAGES = ["mujoco", "gymnasium", "dm_control", "robosuite", "robot_descriptions"]
STATES = 3


def models():
    folders = [f for f in os.environ.get("RIST_MJCF", "").split(os.pathsep) if f]
    for package in PACKAGES:
        found = importlib.util.find_spec(package)
        folders += list(found.submodule_search_locations or []) if found else []
    for folder in folders:
        for path in sorted(glob.glob(os.path.join(folder, "**", "*.xml"), recursive=True)):
            with open(path, encoding="utf-8", errors="replace") as file:
                if "<mujoco" in file.read(20000):
                    yield path


def rates(pitch, roll):
    """Angular velocity in the axes of the base per rate of yaw, pitch, roll."""
    sp, cp, sr, cr = np.sin(pitch), np.cos(pitch), np.sin(roll), np.cos(roll)
    return np.array([[-sp, 0, 1], [cp * sr, cr, 0], [cp * cr, -sr, 0]])


def states(path, floats):
    spec = mujoco.MjSpec.from_file(path)
    model = spec.compile()
    data = mujoco.MjData(model)
    hinges = [j for j in range(model.njnt) if model.jnt_type[j] in (2, 3)]
    body_of = [model.jnt_bodyid[j] for j in hinges]
    free = [j for j in range(model.njnt) if model.jnt_type[j] == 0]
    root = None
    if floats:
        roots = [model.body_rootid[b] for b in body_of]
        root = next(j for j in free if not hinges or model.jnt_bodyid[j] in roots)
        hinges = [j for j in hinges if model.body_rootid[model.jnt_bodyid[j]] == model.jnt_bodyid[root]]
    else:
        bodies = [model.jnt_bodyid[j] for j in free]
        hinges = [j for j in hinges if model.body_rootid[model.jnt_bodyid[j]] not in bodies]
    random = np.random.default_rng(7)
    n = len(hinges) + (6 if floats else 0)
    by_mesh = any(
        g.type == mujoco.mjtGeom.mjGEOM_MESH and g.mass != 0 and g.density != 0
        for b in spec.bodies
        if not b.explicitinertial
        for g in b.geoms
    )
    print(n, int(by_mesh))
    for _ in range(STATES):
        q, dq = random.uniform(-1.2, 1.2, n), random.uniform(-2, 2, n)
        data.qpos[:], data.qvel[:], acceleration = model.qpos0, 0, np.zeros(model.nv)
        turn = np.zeros((model.nv, n))
        first = 6 if floats else 0
        for k, j in enumerate(hinges):
            data.qpos[model.jnt_qposadr[j]] = q[first + k]
            turn[model.jnt_dofadr[j], first + k] = 1
        if floats:
            at, dof = model.jnt_qposadr[root], model.jnt_dofadr[root]
            data.qpos[at : at + 3] = q[:3]
            half = q[3:6] / 2
            turns = [(np.cos(h), *(np.sin(h) * np.eye(3)[axis])) for h, axis in zip(half, (2, 1, 0))]
            first_two, whole = np.zeros(4), np.zeros(4)
            mujoco.mju_mulQuat(first_two, np.array(turns[0]), np.array(turns[1]))
            mujoco.mju_mulQuat(whole, first_two, np.array(turns[2]))
            data.qpos[at + 3 : at + 7] = whole
            turn[dof : dof + 3, :3] = np.eye(3)
            turn[dof + 3 : dof + 6, 3:6] = rates(q[4], q[5])
            # The derivative of the rates along the motion, by a complex step.
            step = 1e-30
            slope = rates(q[4] + 1j * step * dq[4], q[5] + 1j * step * dq[5]).imag / step
            acceleration[dof + 3 : dof + 6] = slope @ dq[3:6]
        data.qvel[:] = turn @ dq
        mujoco.mj_forward(model, data)
        mass = np.zeros((model.nv, model.nv))
        mujoco.mj_fullM(model, mass, data.qM) if hasattr(data, "qM") else mujoco.mj_fullM(model, data, mass)
        bias = data.qfrc_bias + mass @ acceleration
        values = [q, dq, (turn.T @ mass @ turn).ravel(), turn.T @ bias]
        print(" ".join(repr(float(x)) for x in np.concatenate(values)))


if sys.argv[1] == "list":
    print("\n".join(models()))
elif sys.argv[1] == "states":
    states(sys.argv[3], sys.argv[2] == "1")
else:
    for line in sys.stdin.read().splitlines():
        floats, path = line.split(" ", 1)
        print("model", path)
        try:
            states(path, floats == "1")
        except Exception as refused:
            print("refused", str(refused).replace("\n", " "))
