"""A motion at many instants, by Pinocchio and coal: contacts, limits, torques, floor. Knows nothing of rist but its files.

Arguments: instants, then a URDF and a motion as JSON, again and again. Prints a line of JSON a motion.
"""

import json
import os
import pathlib
import sys
import xml.etree.ElementTree as xml

import coal
import numpy as np
import pinocchio as pin


def series(joint, period, s):
    """Position, velocity and acceleration of a joint, s seconds after the start of a period."""
    w = 2 * np.pi / period
    l = w * np.arange(1, len(joint["cosine"]) + 1)
    a, b = np.array(joint["cosine"]), np.array(joint["sine"])
    sin, cos = np.sin(l * s), np.cos(l * s)
    q = joint["centre"] + np.sum(a / l * sin - b / l * cos)
    return q, np.sum(a * cos + b * sin), np.sum(l * (b * cos - a * sin))


def bezier(p, u, d):
    """Position, velocity and acceleration of a polynomial of degree 4 by its control points, over d seconds."""
    found = []
    for k in range(3):
        n = len(p) - 1
        binomial = [1.0]
        for i in range(n):
            binomial.append(binomial[-1] * (n - i) / (i + 1))
        found.append(sum(c * u**i * (1 - u) ** (n - i) * x for i, (c, x) in enumerate(zip(binomial, p))))
        p = [n / d * (y - x) for x, y in zip(p, p[1:])]
    return found


def state(motion, t):
    """q, dq and ddq at t, by docs/motion-and-plan.md."""
    period, d = motion["period_s"], motion["blend_s"]
    end = d + motion["repetitions"] * period
    rows = []
    for joint in motion["joints"]:
        q, v, a = series(joint, period, 0.0)
        start, stop = q - d * v / 2 + d * d * a / 12, q + d * v / 2 + d * d * a / 12
        if t < d:
            rows.append(bezier([start, start, start, q - d * v / 4, q], t / d, d))
        elif t > end:
            rows.append(bezier([q, q + d * v / 4, stop, stop, stop], (t - end) / d, d))
        else:
            rows.append(series(joint, period, (t - d) % period))
    return np.array(rows).T


def lowest(shape, placement):
    """The least z of a shape."""
    r, z = placement.rotation, placement.translation[2]
    up = r[2]
    if isinstance(shape, coal.Sphere):
        return z - shape.radius
    if isinstance(shape, coal.Cylinder):
        return z - shape.halfLength * abs(up[2]) - shape.radius * np.hypot(up[0], up[1])
    if isinstance(shape, coal.Box):
        return z - np.abs(up) @ np.array(shape.halfSide)
    if isinstance(shape, coal.Capsule):
        return z - shape.halfLength * abs(up[2]) - shape.radius
    vertices = shape.vertices()
    return z + float(np.min(np.asarray(vertices) @ up))


def followers(urdf, model):
    """Joints that follow others: (joint, multiplier, offset) by the name of the one that they follow."""
    found = {}
    for joint in xml.parse(urdf).getroot().iter("joint"):
        mimic = joint.find("mimic")
        if mimic is not None:
            own = model.joints[model.getJointId(joint.get("name"))]
            entry = (own, float(mimic.get("multiplier", 1)), float(mimic.get("offset", 0)))
            found.setdefault(mimic.get("joint"), []).append(entry)
    return found


def look(urdf, motion, instants):
    places = [str(folder) for folder in pathlib.Path(urdf).resolve().parents]
    model = pin.buildModelFromUrdf(urdf)
    bodies = pin.buildGeomFromUrdf(model, urdf, pin.GeometryType.COLLISION, package_dirs=places)
    data, where = model.createData(), pin.GeometryData(bodies)
    link = lambda g: model.frames[bodies.geometryObjects[g].parentFrame].name
    certified = {}
    for row in motion["certificate"]:
        if row["limit"] == "distance":
            certified[frozenset(row["subject"].split(" and "))] = row["nowhere_beyond"]
    floor = motion["space"].get("floor")
    floor = floor if isinstance(floor, (int, float)) else None
    held = {row["subject"].rsplit(" at ", 1)[0] for row in motion["certificate"] if row["subject"].endswith(" at the floor")}
    pairs = []
    for i in range(len(bodies.geometryObjects)):
        for j in range(i):
            names = frozenset([link(i), link(j)])
            if names in certified:
                pairs.append((i, j, certified[names]))
    indices = [model.joints[model.getJointId(joint["coordinate"])] for joint in motion["joints"]]
    follow = followers(urdf, model)
    duration = 2 * motion["blend_s"] + motion["repetitions"] * motion["period_s"]
    # The first blend and one period, and the last blend: all periods are alike.
    once = motion["blend_s"] + motion["period_s"]
    times = np.concatenate([np.linspace(0, once, instants), np.linspace(duration - motion["blend_s"], duration, instants // 10)])
    found = {"instants": len(times), "pairs": len(pairs), "contacts": 0, "below_bound": 0, "limits": 0, "torques": 0, "below_floor": 0}
    request, slack = coal.DistanceRequest(), 1e-6
    nearest = np.inf
    for t in times:
        rows = state(motion, t)
        q, v, a = pin.neutral(model), np.zeros(model.nv), np.zeros(model.nv)
        for k, joint in enumerate(indices):
            if joint.nq == 1:
                q[joint.idx_q] = rows[0][k]
            else:
                q[joint.idx_q : joint.idx_q + 2] = np.cos(rows[0][k]), np.sin(rows[0][k])
            v[joint.idx_v], a[joint.idx_v] = rows[1][k], rows[2][k]
            for other, times, offset in follow.get(motion["joints"][k]["coordinate"], []):
                q[other.idx_q] = times * rows[0][k] + offset
                v[other.idx_v], a[other.idx_v] = times * rows[1][k], times * rows[2][k]
            if joint.nq == 1:
                low, high = model.lowerPositionLimit[joint.idx_q], model.upperPositionLimit[joint.idx_q]
                found["limits"] += not low - 1e-9 <= rows[0][k] <= high + 1e-9
            found["limits"] += not abs(rows[1][k]) <= model.velocityLimit[joint.idx_v] * (1 + 1e-9)
        tau = pin.rnea(model, data, q, v, a)
        for joint, own in zip(indices, motion["joints"]):
            effort = own["limits"].get("effort")
            if effort is not None:
                friction = model.friction[joint.idx_v] + abs(model.damping[joint.idx_v] * v[joint.idx_v])
                torque = tau[joint.idx_v] + sum(times * tau[other.idx_v] for other, times, _ in follow.get(own["coordinate"], []))
                found["torques"] += not abs(torque) + friction <= model.effortLimit[joint.idx_v] * (1 + 1e-9)
        pin.updateGeometryPlacements(model, data, bodies, where, q)
        for i, j, bound in pairs:
            # Balls about the bodies first.
            a_, b_ = bodies.geometryObjects[i].geometry, bodies.geometryObjects[j].geometry
            result = coal.DistanceResult()
            distance = coal.distance(a_, as_transform(where.oMg[i]), b_, as_transform(where.oMg[j]), request, result)
            found["contacts"] += distance <= 0
            found["below_bound"] += distance < bound - slack
            nearest = min(nearest, distance)
        if floor is not None:
            for g in range(len(bodies.geometryObjects)):
                if link(g) in held:
                    found["below_floor"] += lowest(bodies.geometryObjects[g].geometry, where.oMg[g]) < floor - slack
    found = {what: int(count) for what, count in found.items()}
    found["nearest"] = float(nearest) if np.isfinite(nearest) else None
    return found


def as_transform(placement):
    return coal.Transform3s(placement.rotation, placement.translation)


if __name__ == "__main__":
    instants, files = int(sys.argv[1]), sys.argv[2:]
    for urdf, motion in zip(files[::2], files[1::2]):
        with open(motion) as file:
            found = look(urdf, json.load(file), instants)
        print(json.dumps({"urdf": os.path.basename(urdf), **found}), flush=True)
