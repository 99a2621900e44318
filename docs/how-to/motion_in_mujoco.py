"""A motion of `rist excite` (a Fourier series) in MuJoCo, a hundred times as fine as it is played.

    python docs/how-to/motion_in_mujoco.py ROBOT.urdf motion.yaml

Nothing of rist is used: the series is evaluated by its formula, torques are MuJoCo's inverse dynamics of the URDF, and
contacts are those of its collision geometry. Limits are those that motion.yaml states. Needs mujoco, numpy and yaml.
A robot in YAML is a URDF after `rist convert`.
"""

import pathlib
import re
import sys

import mujoco
import numpy
import yaml

urdf, motion = pathlib.Path(sys.argv[1]), yaml.safe_load(open(sys.argv[2]))
# Fixed links stay bodies of their own, so that contacts have names; pictures are not needed.
text = re.sub(r"<mujoco>.*?</mujoco>", "", urdf.read_text(), flags=re.S)
options = '<mujoco><compiler fusestatic="false" discardvisual="true" balanceinertia="false"/></mujoco>'
model = mujoco.MjModel.from_xml_string(re.sub(r"(<robot[^>]*>)", rf"\1{options}", text, count=1))
data = mujoco.MjData(model)
joints = [(model.joint(joint["coordinate"]), joint) for joint in motion["joints"]]

period, rate = motion["period_s"], 100 * motion["rate_hz"]
count = int(period * rate) + 1
t = numpy.arange(count) / rate
share = motion["effort_share"]
worst = {}


def hold(name, limit, value, bound):
    """Keeps the greatest share of a bound that a limit has used."""
    used = numpy.max(numpy.abs(value)) / bound
    worst[name, limit] = max(used, worst.get((name, limit), 0.0))


q, dq, ddq = (numpy.zeros((count, model.nv)) for _ in range(3))
for place, joint in joints:
    i, limits = place.dofadr[0], joint["limits"]
    q[:, i] = joint["centre"]
    jerk = numpy.zeros(count)  # cosine and sine are amplitudes of the velocity
    for harmonic, (a, b) in enumerate(zip(joint["cosine"], joint["sine"]), start=1):
        w = 2 * numpy.pi * harmonic / period
        s, c = numpy.sin(w * t), numpy.cos(w * t)
        q[:, i] += (a * s - b * c) / w
        dq[:, i] += a * c + b * s
        ddq[:, i] += w * (b * c - a * s)
        jerk -= w * w * (a * c + b * s)
    low, high = limits["position"]
    hold(joint["coordinate"], "position", q[:, i] - (low + high) / 2, (high - low) / 2)
    hold(joint["coordinate"], "velocity", dq[:, i], limits["velocity"])
    hold(joint["coordinate"], "acceleration", ddq[:, i], limits["acceleration"])
    hold(joint["coordinate"], "jerk", jerk, limits["jerk"])

touching = set()
for instant in range(count):
    data.qpos[:], data.qvel[:], data.qacc[:] = q[instant], dq[instant], ddq[instant]
    mujoco.mj_inverse(model, data)
    for place, joint in joints:
        if (effort := joint["limits"].get("effort")) is not None:
            # The bound holds the motion without dry friction; MuJoCo's constraints of friction and contact are apart.
            rigid = data.qfrc_inverse[place.dofadr[0]] + data.qfrc_constraint[place.dofadr[0]]
            hold(joint["coordinate"], "torque", rigid, share * effort)
    for contact in data.contact[: data.ncon]:
        bodies = (model.body(model.geom_bodyid[geom]).name for geom in contact.geom)
        touching.add(tuple(sorted(bodies)))

broken = [(key, used) for key, used in worst.items() if used > 1 + 1e-9]
for (name, limit), used in sorted(worst.items(), key=lambda item: -item[1])[:8]:
    print(f"{name:<20} {limit:<12} {100 * used:8.3f} % of its limit")
print(f"{count} instants, {len(broken)} limits broken, contacts: {sorted(touching) or 'none'}")
sys.exit(1 if broken or touching else 0)
