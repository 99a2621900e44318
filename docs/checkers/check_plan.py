"""Proves anew how good a plan of `rist plan --nodes` is, with nothing of rist.

    python docs/checkers/check_plan.py MODEL plan.yaml [--as-given]

MODEL is a URDF or a description in YAML; formats and formulas: docs/motion-and-plan.md. Needs numpy. Exit code 0:
no plan of as many of the candidates is better than the plan says; 1: one may be, or the plan says what is not so;
2: a file cannot be read.

How: the rows of every candidate are made from the description and its motion. For any positive definite T and every
plan, with F the sum of its candidates' information F_i = W_i'W_i,

    log det F <= sum tr(T F_i) - p - log det T

so every leaf of the tree bounds the plans between its splits by the greatest sum of gains tr(T F_i), T the inverse
of F at the leaf's design. T is the product of a triangle as the computer has it, and the gains are rounded up, so
that the bound holds whatever the inverse is worth. Columns are those of links of this program: another basis of the
parameters changes every log det F by the same number."""

import math
import pathlib
import sys
import xml.etree.ElementTree as xml

import numpy as np

from description import Fault, parse_yaml, read_description, read_urdf, skew

E = 2.0**-52
RANK = 1e-9  # relative: smaller singular values of all rows are none
EQUAL = 1e-9  # relative: information of candidates that count as one
INSTANTS = 200  # of a period of a swing


# ---------------------------------------------------------------- rows of the candidates


def linear_in(v, signs):
    """Matrices that are linear in v, [instant, 3]: entry k of `signs` times component |k| - 1, 0 for none."""
    entry = lambda k: math.copysign(1.0, k) * v[:, abs(k) - 1] if k else np.zeros(len(v))
    return np.stack([np.stack([entry(k) for k in row], 1) for row in signs], 1)


def skews(v):
    return linear_in(v, ((0, -3, 2), (3, 0, -1), (-2, 1, 0)))


def spins(v):
    """I v as a matrix times (XX, XY, XZ, YY, YZ, ZZ)."""
    return linear_in(v, ((1, 2, 3, 0, 0, 0), (0, 1, 0, 2, 3, 0), (0, 0, 1, 0, 2, 3)))


def columns(robot, q, dq, ddq):
    """Torques per unit of the ten parameters of each link, and of its rotor: [coordinate, instant, parameter].

    Moments about the origins of links' frames; q, dq, ddq: [coordinate, instant].
    """
    count, found, poses = q.shape[1], [], []
    place_of = robot.coordinates.index
    at = lambda values, link: sum((m * values[place_of(k)] for k, m in link.terms.items()), np.zeros(count))
    for link in robot.links:
        turn, x = np.tile(link.rotation, (count, 1, 1)), at(q, link) + link.offset
        step = np.tile(link.position, (count, 1))
        if link.kind == "revolute":
            k = skew(link.axis)
            turn = turn @ (np.eye(3) + np.sin(x)[:, None, None] * k + (1 - np.cos(x))[:, None, None] * (k @ k))
        elif link.kind == "prismatic":
            step = step + x[:, None] * (link.rotation @ link.axis)
        if link.parent is None:
            turn0, place, w, dw, a = np.tile(np.eye(3), (count, 1, 1)), np.zeros((count, 3)), 0.0, 0.0, -robot.gravity
            w, dw, a = (np.zeros((count, 3)) + v for v in (w, dw, a))
        else:
            turn0, place, w, dw, a = poses[link.parent][:5]
        # All in the frame of the base.
        lever = np.einsum("tij,tj->ti", turn0, step)
        a = a + np.cross(dw, lever) + np.cross(w, np.cross(w, lever))
        turn, place = turn0 @ turn, place + lever
        axis = turn @ link.axis
        if link.kind == "revolute":
            dw = dw + np.cross(w, axis) * at(dq, link)[:, None] + axis * at(ddq, link)[:, None]
            w = w + axis * at(dq, link)[:, None]
        elif link.kind == "prismatic":
            a = a + 2 * np.cross(w, axis) * at(dq, link)[:, None] + axis * at(ddq, link)[:, None]
        poses.append((turn, place, w, dw, a, axis))
    wrenches = []
    for link, (turn, place, w, dw, a, _) in zip(robot.links, poses):
        back = lambda v: np.einsum("tji,tj->ti", turn, v)
        w, dw, a = back(w), back(dw), back(a)
        # Columns of XX XY XZ YY YZ ZZ, MX MY MZ, M.
        force = np.concatenate([np.zeros((count, 3, 6)), skews(dw) + skews(w) @ skews(w), a[:, :, None]], 2)
        torque = np.concatenate([spins(dw) + skews(w) @ spins(w), -skews(a), np.zeros((count, 3, 1))], 2)
        wrenches.append((turn @ force, turn @ torque, place))
    blocks = np.zeros((len(robot.coordinates), count, 11 * len(robot.links)))
    for k, link in enumerate(robot.links):
        force, torque, place = wrenches[k]
        for j in robot.chain(k):
            joint, (_, origin, _, _, _, axis) = robot.links[j], poses[j]
            if joint.kind == "fixed":
                continue
            moment = torque + np.cross((place - origin)[:, :, None], force, axisa=1, axisb=1, axisc=1)
            effect = np.einsum("ti,tij->tj", axis, moment if joint.kind == "revolute" else force)
            for name, multiple in joint.terms.items():
                blocks[robot.coordinates.index(name)][:, 11 * k : 11 * k + 10] += multiple * effect
        if link.has_rotor:
            for name, multiple in link.terms.items():
                blocks[robot.coordinates.index(name)][:, 11 * k + 10] += multiple * at(ddq, link)
    return blocks


def profile(word, u):
    """Position in [-1, 1] of a swing with its derivatives by u = t/T; at a corner the mean of both sides."""
    if word == "bang_bang":
        s = np.where(u < 0.25, u, np.where(u < 0.75, u - 0.5, u - 1.0))
        sign, rest = np.where((u >= 0.25) & (u < 0.75), -1.0, 1.0), np.where((u >= 0.25) & (u < 0.75), 1.0, -1.0)
        corner = (u == 0.25) | (u == 0.75)
        return rest + sign * 16 * s * s, sign * 32 * s, np.where(corner, 0.0, sign * 32)
    if word != "smooth":
        raise Fault(f"there is no profile `{word}`")
    s, sign = np.where(u < 0.5, 2 * u, 2 * u - 1), np.where(u < 0.5, 1.0, -1.0)
    c = 1 - s
    p = s**4 * (35 - 84 * s + 70 * s**2 - 20 * s**3)
    return sign * (2 * p - 1), sign * 4 * 140 * (s * c) ** 3, sign * 8 * 420 * (s * c) ** 2 * (1 - 2 * s)


def rows_of(robot, candidate, names, h, noise):
    """The rows of a motion that follows its reference, over their deviations: [row, parameter]."""
    n, fast, slow = len(names), names.index(candidate["fast"]), [names.index(x) for x in candidate.get("slow") or []]
    centre, kind = np.array(candidate["centre"], float), candidate["kind"]
    place = [robot.coordinates.index(name) for name in names]
    order = lambda x: x[np.argsort(place)]
    if candidate.get("swing"):
        swing = candidate["swing"]
        period, half = swing["period_samples"] * h, np.array(swing["half_range"], float)
        p, dp, ddp = profile(swing["profile"], np.arange(INSTANTS) / INSTANTS)
        moving = np.zeros(n)
        moving[[fast, *slow]] = half[[fast, *slow]]
        q, dq, ddq = centre[:, None] + np.outer(half, p), np.outer(half, dp) / period, np.outer(half, ddp) / period**2
        y = columns(robot, order(q), order(dq), order(ddq))
        share = math.sqrt(INSTANTS / (swing["periods"] * swing["period_samples"]))
        squares, couplings = [(j, 2) for j in slow], [(j, 1) for j in slow]
        equations = {"inertial": [(fast, 1)], "centrifugal": squares, "coupling": couplings,
                     "mixed": [(fast, 1)] + [pair for two in zip(squares, couplings) for pair in two]}[kind]
        found = []
        for joint, harmonic in equations:
            turn = np.exp(-2j * math.pi * harmonic * np.arange(INSTANTS) / INSTANTS)
            v = turn @ (ddq[fast] if harmonic == 1 else dq[fast] ** 2)
            if v == 0:
                continue
            row = np.real((turn @ y[place[joint]]) * np.conj(v)) / abs(v) ** 2
            found.append(row * abs(v) / (noise[joint] * share * math.sqrt(INSTANTS / 2)))
        return np.array(found).reshape(-1, y.shape[2])
    sweep, at_rest = candidate["sweep"], 0.1
    velocity, acceleration, length = (sweep[k] for k in ("velocity_rad_per_s", "acceleration_rad_per_s2", "range_rad"))
    ramp, whole = velocity / acceleration, velocity / acceleration + length / velocity
    found = []
    for way, start in ((1.0, at_rest), (-1.0, 3 * at_rest + whole)):
        first = math.floor((start + ramp + sweep["settling_s"]) / h) + 1
        end = math.ceil((start + whole - ramp) / h)
        t = np.arange(first, max(first, end)) * h - start
        # Velocity is constant inside the window.
        q = np.tile(centre[:, None], (1, len(t)))
        q[fast] += way * (velocity * (t - ramp / 2) - length / 2)
        y = columns(robot, order(q), 0 * q, 0 * q)[place[fast]]
        found.append(y - y.mean(0))
    return np.linalg.qr(np.concatenate(found), mode="r") / noise[fast]


# ---------------------------------------------------------------- the bound


def gains(rows, starts, information):
    """log det T, rounded down, and the gains tr(T F_i), rounded up; T as good as the inverse of `information`.

    rows: those of all candidates, of which candidate i begins at starts[i].
    """
    p = rows.shape[1]
    # T = U U' of the triangle that the computer has: whatever it is, the bound holds.
    upper = np.linalg.inv(np.linalg.cholesky(information)).T
    whitened = (np.abs(rows @ upper) + (p + 2) * E * (np.abs(rows) @ np.abs(upper))) * (1 + 4 * E)
    gain = np.add.reduceat((whitened**2).sum(1), starts) * (1 + (4 * p + 64) * E)
    log_det = 2 * np.sum(np.log(np.abs(np.diag(upper))))
    return log_det - 1e-12 * (1 + abs(log_det)), gain


def bound_of_tree(proof, blocks, count, out):
    """The greatest log det F that the leaves leave open."""
    p, m = blocks[0].shape[1], len(blocks)
    equal = {int(a): int(b) for a, b in proof.get("equal") or []}
    if any(not 0 <= b < a < m or b in equal for a, b in equal.items()):
        raise Fault("a candidate that stands for another is none that is kept")
    for a, b in equal.items():
        one, other = (blocks[i].T @ blocks[i] for i in (a, b))
        if np.abs(one - other).max() > EQUAL * np.trace(one):
            out(f"candidates {a} and {b} are not equal")
            return math.inf
    rows, starts, designs = np.concatenate(blocks), np.cumsum([0] + [len(b) for b in blocks[:-1]]), {}

    def tangent(k):
        if k not in designs:
            x = np.zeros(m)
            for i, share in proof["designs"][k]:
                x[i] += share
            weights = np.repeat(x, [len(b) for b in blocks])
            designs[k] = gains(rows, starts, (rows * weights[:, None]).T @ rows)
        return designs[k]

    kept = np.array([i not in equal for i in range(m)])
    worst, waiting, seen = -math.inf, [(0, np.zeros(m, int), np.where(kept, count, 0))], set()
    while waiting:
        node, low, high = waiting.pop()
        if node in seen:
            raise Fault("the tree has a circle")
        seen.add(node)
        (kind, entry), = proof["tree"][node].items()
        if kind == "split":
            i, at_most = entry["candidate"], entry["at_most"]
            below, above = high.copy(), low.copy()
            below[i], above[i] = min(high[i], at_most), max(low[i], at_most + 1)
            waiting += [(entry["below"], low, below), (entry["above"], above, high)]
            continue
        if low.sum() > count or high.sum() < count or (low > high).any():
            continue
        log_det, gain = tangent(entry["design"])
        # The greatest sum of gains between the bounds: as many as may be of the greatest.
        left, total = count - low.sum(), float(low @ gain)
        order = np.argsort(-gain)
        room = (high - low)[order]
        total += float(np.minimum(room, np.maximum(left - (np.cumsum(room) - room), 0)) @ gain[order])
        bound = total * (1 + 2 * m * E) - p - log_det
        worst = max(worst, bound) if math.isfinite(bound) else math.inf
    out(f"{len(seen)} nodes, {len(designs)} designs, {len(equal)} candidates that others stand for")
    return worst


def check(model, plan_file, as_given=False, out=print):
    robot = (read_urdf if str(model).endswith((".urdf", ".xml")) else read_description)(model, as_given)
    plan = parse_yaml(pathlib.Path(plan_file).read_text())
    proof, names = plan.get("proof"), plan["coordinates"]
    if not proof or not proof.get("candidates"):
        raise Fault(f"{plan_file}: it has no proof with candidates; `rist plan --nodes` writes one")
    if sorted(names) != sorted(robot.coordinates):
        raise Fault(f"{plan_file}: coordinates {names}; the description has {robot.coordinates}")
    h, noise, motions = float(plan["sample_time_s"]), plan["torque_noise"], proof["candidates"]
    raw = [rows_of(robot, c, names, h, noise) for c in motions]
    # A basis of what all rows span stands for base parameters; columns of one size first.
    size = np.sqrt(sum((b * b).sum(0) for b in raw))
    # What rounding left of a column that is zero stays small.
    raw = [b / np.where(size > RANK * size.max(), size, size.max()) for b in raw]
    _, values, basis = np.linalg.svd(np.linalg.qr(np.concatenate(raw), mode="r"), full_matrices=False)
    p = int((values > RANK * values[0]).sum())
    blocks, good = [b @ basis[:p].T / values[:p] for b in raw], True
    if p != len(plan["parameters"]):
        out(f"the candidates span {p} parameters; the plan has {len(plan['parameters'])}")
        return False
    chosen = []
    for experiment in plan["experiments"]:
        i = experiment.get("candidate")
        keys = ("kind", "fast", "centre", "swing", "sweep")
        same = i is not None and 0 <= i < len(motions) and all(experiment.get(k) == motions[i].get(k) for k in keys)
        if not same or (experiment.get("slow") or []) != (motions[i].get("slow") or []):
            out(f"experiment {experiment['name']} is not its candidate")
            return False
        chosen.append(i)
    value = np.linalg.slogdet(sum(blocks[i].T @ blocks[i] for i in chosen))[1] - 1e-9
    bound = max(bound_of_tree(proof, blocks, len(chosen), out), value)
    efficiency, said = math.exp((value - bound) / p), float(plan["d_efficiency_at_least"])
    # Rows of the plan and of this program differ by rounding.
    good = efficiency >= said - 1e-6
    out("NOT looked at: other motions than the candidates, limits, cond_fro, deviations, fingerprint")
    out(f"{'proven' if good else 'NOT proven'}: D-efficiency at least {efficiency:.6f} of {len(chosen)} experiments of "
        f"{len(motions)} candidates in {p} parameters; the plan says {said:.6f}")
    return good


def main(arguments):
    as_given = "--as-given" in arguments
    arguments = [a for a in arguments if a != "--as-given"]
    if len(arguments) != 2:
        print(__doc__.strip())
        return 2
    try:
        return 0 if check(*arguments, as_given) else 1
    except (Fault, OSError, KeyError, TypeError, ValueError, IndexError, SyntaxError, xml.ParseError,
            np.linalg.LinAlgError) as fault:
        print(f"cannot be read: {type(fault).__name__}: {fault}")
        return 2


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
