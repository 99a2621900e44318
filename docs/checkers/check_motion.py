"""Proves anew that a motion of `rist excite` keeps its limits, with nothing of rist.

    python docs/checkers/check_motion.py MODEL motion.yaml [--limits limits.yaml] [--as-given]

MODEL is a URDF or a description in YAML; formats: docs/motion-and-plan.md. Needs numpy. Exit code 0: all rows are
proven; 1: something is broken or not proven; 2: a file cannot be read. What nobody looks at is printed.

How: the motion is cut into parts of time, t = c + h u, u in [-1, 1]. Every quantity x on a part is a form

    x(u) within x0 + x1 u + [-r, r]

Sums, products, sines and cosines of forms take up in r what is neither constant nor linear in u, and the rounding
of their own computation. Torques are Newton-Euler recursions on forms. Two convex bodies are apart by n.(a - b) for
any unit vector n that separates all their vertices: it is linear in the pose, so that both ends of a part bound it
inside. The vectors are searched; only the bound that a vector proves is believed. A part that proves too little is
halved.

Trusted: the description, the limits file, this program, numpy. Of the motion's file: coefficients and times, and
limits where they are tighter, or stand nowhere else, which is said.
"""

import math
import pathlib
import re
import sys
import xml.etree.ElementTree as xml

import numpy as np

from description import Fault, in_pieces, parse_yaml, read_description, read_urdf
from margins import Margins, stopping_limits

E = 2.0**-52  # twice the rounding of an operation
TINY = 1e-300
CONSTANT = 1e-14  # of rotations and lengths that are computed from the description, relative to 1 and to themselves
SMALL_TORQUE = 1e-9  # N m (N), for what is computed without forms: gravity in the frame of the base


# ---------------------------------------------------------------- forms


class Form:
    """x0 + x1 u + [-r, r], u in [-1, 1], of many parts at once; the number 0 stands for what is zero everywhere."""

    __slots__ = ("x0", "x1", "r")
    __array_ufunc__ = None

    def __init__(self, x0, x1, r):
        self.x0, self.x1, self.r = x0, x1, r

    def size(self):
        return np.abs(self.x0) + np.abs(self.x1)

    def __neg__(self):
        return Form(-self.x0, -self.x1, self.r)

    def __add__(self, other):
        if not isinstance(other, Form):
            if other == 0:
                return self
            other = Form(other, 0.0, 0.0)
        x0, x1 = self.x0 + other.x0, self.x1 + other.x1
        return Form(x0, x1, (self.r + other.r) * (1 + 4 * E) + E * (np.abs(x0) + np.abs(x1)) + TINY)

    __radd__ = __add__

    def __sub__(self, other):
        return self + (-other)

    def __rsub__(self, other):
        return -self + other

    def __mul__(self, other):
        if not isinstance(other, Form):
            if other == 0:
                return 0
            # A constant of the description, which is off by a few roundings where it is not a whole number.
            off = 0.0 if other in (1.0, -1.0) else CONSTANT * abs(other)
            r = (abs(other) * self.r + (off + 2 * E * abs(other)) * (self.size() + self.r)) * (1 + 8 * E)
            return Form(other * self.x0, other * self.x1, r + TINY)
        a, b = self.size(), other.size()
        bend = 0.5 * (self.x1 * other.x1)
        x0 = self.x0 * other.x0 + bend
        x1 = self.x0 * other.x1 + self.x1 * other.x0
        r = np.abs(bend) + self.r * (b + other.r) + other.r * a + 4 * E * a * b
        return Form(x0, x1, r * (1 + 8 * E) + TINY)

    __rmul__ = __mul__

    def sin_cos(self):
        s, c, d = np.sin(self.x0), np.cos(self.x0), self.x1
        third = (np.abs(d) + self.r) ** 3 / 6 + 16 * E

        def of(s, c):
            # s + c d u - s d^2 u^2 / 2, the square in [0, 1].
            r = np.abs(c) * self.r + np.abs(s) * (d * d / 4 + np.abs(d) * self.r + self.r**2 / 2) + third
            return Form(s - s * d * d / 4, c * d, r * (1 + 8 * E))

        return of(s, c), of(c, -s)

    def magnitude(self):
        return (self.size() + self.r) * (1 + 4 * E)


def dot(a, b):
    total = 0
    for x, y in zip(a, b):
        if not (isinstance(x, (int, float)) and x == 0) and not (isinstance(y, (int, float)) and y == 0):
            total = total + x * y
    return total


def cross(a, b):
    return [dot((a[i], -a[j]), (b[j], b[i])) for i, j in ((1, 2), (2, 0), (0, 1))]


def turned(rotation, v):
    return [dot(row, v) for row in rotation]


def transposed(rotation):
    return [list(column) for column in zip(*rotation)]


def plain(array):
    """Python numbers, so that zeros are known."""
    return array.tolist()


def joint_pose(link, q):
    """Rotation and position of a link in that of its parent, with forms of the coordinates."""
    position = dot([1.0] * len(link.terms), [q[k] * m for k, m in link.terms.items()]) + link.offset
    fixed, shift, axis = plain(link.rotation), plain(link.position), plain(link.axis)
    if link.kind == "fixed":
        return fixed, shift
    if link.kind == "prismatic":
        along = [position * x if x else 0 for x in axis]
        return fixed, [a + b for a, b in zip(turned(fixed, along), shift)]
    s, c = position.sin_cos()
    rest = -c + 1.0
    turn = [[0] * 3 for _ in range(3)]
    for i in range(3):
        for j in range(3):
            outer = axis[i] * axis[j]
            turn[i][j] = (c if i == j else 0) + (rest * outer if outer else 0)
            if i == j and outer == 1.0:
                turn[i][j] = 1.0
    for i, j, k, sign in ((1, 0, 2, 1), (0, 1, 2, -1), (0, 2, 1, 1), (2, 0, 1, -1), (2, 1, 0, 1), (1, 2, 0, -1)):
        if axis[k]:
            turn[i][j] = turn[i][j] + s * (sign * axis[k])
    return [[dot(row, column) for column in transposed(turn)] for row in fixed], shift


def compose(a, b):
    (ra, pa), (rb, pb) = a, b
    rotation = [[dot(row, column) for column in transposed(rb)] for row in ra]
    return rotation, [x + y for x, y in zip(turned(ra, pb), pa)]


IDENTITY = (plain(np.eye(3)), [0, 0, 0])


def torques(robot, q, dq, ddq):
    """By coordinate: tau without friction. Newton-Euler [Luh, Walker, Paul 1980], moments about origins of frames."""
    states = []
    sums = lambda values, link: dot([1.0] * len(link.terms), [values[k] * m for k, m in link.terms.items()])
    for link in robot.links:
        rotation, shift = joint_pose(link, q)
        back, rest = transposed(rotation), ([0, 0, 0], [0, 0, 0], [-g for g in plain(robot.gravity)])
        w, dw, a = states[link.parent][1:4] if link.parent is not None else rest
        carried = [x + y for x, y in zip(cross(dw, shift), cross(w, cross(w, shift)))]
        a = turned(back, [x + y for x, y in zip(a, carried)])
        w, dw = turned(back, w), turned(back, dw)
        axis = plain(link.axis)
        if link.kind != "fixed":
            v, dv = sums(dq, link), sums(ddq, link)
            along = [v * x if x else 0 for x in axis]
            push = [dv * x if x else 0 for x in axis]
            turn = cross(w, along)
            if link.kind == "revolute":
                dw = [x + y + z for x, y, z in zip(dw, turn, push)]
                w = [x + y for x, y in zip(w, along)]
            else:
                a = [x + 2.0 * y + z for x, y, z in zip(a, turn, push)]
        mass, moment, inertia = link.mass, plain(link.moment), plain(link.inertia)
        spin = cross(w, cross(w, moment))
        force = [mass * x + y + z for x, y, z in zip(a, cross(dw, moment), spin)]
        own = cross(w, turned(inertia, w))
        torque = [x + y + z for x, y, z in zip(turned(inertia, dw), own, cross(moment, a))]
        states.append([(rotation, shift), w, dw, a, force, torque])
    found = {name: 0 for name in robot.coordinates}
    for k in reversed(range(len(robot.links))):
        link, ((rotation, shift), _, _, _, force, torque) = robot.links[k], states[k]
        if link.kind != "fixed":
            along = dot(plain(link.axis), torque if link.kind == "revolute" else force)
            if link.rotor:
                along = along + sums(ddq, link) * link.rotor
            for name, multiple in link.terms.items():
                found[name] = found[name] + along * multiple
        if link.parent is not None:
            up = turned(rotation, force)
            lever = [x + y for x, y in zip(turned(rotation, torque), cross(shift, up))]
            states[link.parent][4] = [x + y for x, y in zip(states[link.parent][4], up)]
            states[link.parent][5] = [x + y for x, y in zip(states[link.parent][5], lever)]
    return found


# ---------------------------------------------------------------- the motion

ORDER = 5  # derivatives that are known at an instant; the next one is bounded


class Series:
    """A period of q = c + sum_l (a_l sin(l w t) - b_l cos(l w t)) / (l w)."""

    def __init__(self, joints, period, start):
        self.length, self.start = period, start
        self.centre = np.array([j["centre"] for j in joints], float)
        a, b = (np.array([j[key] for j in joints], float) for key in ("cosine", "sine"))
        self.a, self.b = a, b
        self.w = 2 * math.pi / period * np.arange(1, a.shape[1] + 1)
        self.amplitude = np.abs(a) + np.abs(b)
        self.bound = (np.hypot(a, b) @ self.w**ORDER) * (1 + 64 * E)  # of the derivative after the last

    def at(self, t):
        """[k][joint, part]: the k-th derivative, and how far it is off."""
        phase = np.outer(self.w, t)
        s, c, off = np.sin(phase), np.cos(phase), np.abs(phase) * 8 * E + 32 * E
        found = []
        for k in range(ORDER + 1):
            along, across = ((s, -c), (c, s), (-s, c), (-c, -s))[k % 4]
            scale = (self.w ** (k - 1.0))[:, None]
            value = self.a @ (scale * along) + self.b @ (scale * across)
            away = self.amplitude @ (scale * off)
            if k == 0:
                value, away = value + self.centre[:, None], away + 4 * E * np.abs(self.centre)[:, None]
            found.append((value, away))
        return found


class Polynomial:
    """A polynomial of degree at most 5 of each joint, in t / length; `off`: how far its coefficients are off."""

    def __init__(self, coefficients, off, length, start):
        self.length, self.start, self.off = length, start, off
        self.coefficients = np.array(coefficients, float)  # [joint, power]
        self.bound = np.zeros(len(self.coefficients))

    def at(self, t):
        x, coefficients, found = t / self.length, self.coefficients, []
        for k in range(ORDER + 1):
            value, size = (sum(f[:, [i]] * x**i for i in range(f.shape[1])) if f.shape[1] else 0.0 * x
                           for f in (coefficients, np.abs(coefficients)))
            scale = self.length**-k
            away = (size * 64 * E + self.off[:, None] * math.factorial(ORDER) * 2) * scale
            found.append((np.broadcast_to(value * scale, (len(self.off), len(t))), away + 0 * x))
            coefficients = coefficients[:, 1:] * np.arange(1, coefficients.shape[1])
        return found


def pieces_of(motion):
    """The pieces of a motion, in the order of time; all periods are one."""
    joints, period = motion["joints"], float(motion["period_s"])
    blend, repetitions = motion.get("blend_s"), int(motion["repetitions"])
    if not (period > 0 and repetitions > 0 and joints and (blend is None or blend > 0)):
        raise Fault("the motion has no period, joint or repetition")
    if blend is None:
        return spline(joints, period)
    blend = float(blend)
    series = Series(joints, period, blend)
    (q, off), (v, _), (a, _) = ([x[:, 0] for x in pair] for pair in series.at(np.zeros(1))[:3])
    rest = [q + sign * blend * v / 2 + blend**2 * a / 12 for sign in (-1, 1)]
    controls = [[rest[0]] * 3 + [q - blend * v / 4, q], [q, q + blend * v / 4] + [rest[1]] * 3]
    off = 64 * E * (np.abs(q) + blend * np.abs(v) + blend**2 * np.abs(a)) + off * 16
    off += 64 * E * (series.amplitude @ (1 / series.w + blend + blend**2 * series.w))
    starts = (0.0, blend + repetitions * period)
    ends = [Polynomial(power_form(np.array(c).T), off * 100, blend, t) for c, t in zip(controls, starts)]
    return [ends[0], series, ends[1]]


def power_form(points):
    """Coefficients in u^k of Bezier polynomials with these control points, [joint, point]."""
    n, found, row = points.shape[1] - 1, [], points
    for k in range(n + 1):
        found.append(math.comb(n, k) * row[:, 0])
        row = row[:, 1:] - row[:, :-1]
    return np.array(found).T


def spline(joints, period):
    """The spans of a clamped quintic spline: knots 0 (six times), 1 .. K-1, K (six times), in units of period / K."""
    rest = np.array([j["centre"] for j in joints], float)
    inner = np.array([j["control_points"] for j in joints], float)
    spans = inner.shape[1] + 1
    points = np.c_[rest, rest, rest, rest[:, None] + inner, rest, rest, rest]
    knot = lambda i: float(min(max(i - 5, 0), spans))
    found = []
    for span in range(spans):
        # The Bezier points of the span: the blossom at 5 - j times its start and j times its end.
        controls = []
        for j in range(6):
            row = points[:, span : span + 6]
            for step in range(1, 6):
                u = span + (1.0 if step <= j else 0.0)
                share = np.array([(u - knot(span + step + i)) / (knot(span + 6 + i) - knot(span + step + i))
                                  for i in range(6 - step)])
                row = row[:, :-1] + (row[:, 1:] - row[:, :-1]) * share
            controls.append(row[:, 0])
        off = 4000 * E * np.abs(points).max(1)
        found.append(Polynomial(power_form(np.array(controls).T), off, period / spans, span * period / spans))
    return found


class Parts:
    """Parts of one piece, of equal width: their middles and half widths, and the motion on them."""

    def __init__(self, piece, level, index):
        self.piece, self.level, self.index = piece, level, index
        half = 0.5 * piece.length / 2.0**level
        self.half = half * (1 + 1e-9)  # so that parts overlap
        self.middle = (2.0 * index + 1.0) * half
        self.derivatives = piece.at(self.middle)

    def taylor(self, d):
        """Terms of the d-th derivative in u, and the remainder."""
        terms = [x * (self.half**k / math.factorial(k)) for k, (x, _) in enumerate(self.derivatives[d:])]
        rest = self.piece.bound[:, None] * self.half ** (ORDER + 1 - d) / math.factorial(ORDER + 1 - d)
        off = sum(o * (self.half**k / math.factorial(k)) for k, (_, o) in enumerate(self.derivatives[d:]))
        return terms, (rest + off + 16 * E * sum(np.abs(x) for x in terms)) * (1 + 16 * E)

    def forms(self, d, names, off=None):
        """Of the d-th derivative; `off`: how far each joint may be from it."""
        terms, rest = self.taylor(d)
        x0, x1, r = terms[0], terms[1], rest
        if len(terms) > 2:
            x0, r = x0 + 0.5 * terms[2], r + 0.5 * np.abs(terms[2])
        r = r + sum(np.abs(x) for x in terms[3:])
        off = off or {}
        return {name: Form(x0[k], x1[k], (r[k] + off.get(name, 0.0)) * (1 + 8 * E)) for k, name in enumerate(names)}

    def range(self, d):
        """Least and greatest of the d-th derivative, [joint, part]."""
        terms, rest = self.taylor(d)
        linear = np.abs(terms[1]) if len(terms) > 1 else 0.0
        bend = terms[2] if len(terms) > 2 else 0.0 * terms[0]
        rest = rest + sum(np.abs(x) for x in terms[3:]) + linear
        return terms[0] + np.minimum(bend, 0) - rest, terms[0] + np.maximum(bend, 0) + rest


FIRST_LEVEL, LAST_LEVEL, MOST_AT_ONCE = 6, 24, 4096


def prove(pieces, look, subjects):
    """Halves parts until `look(parts)` proves all subjects on them. It gives (room that is proven, room in the middle).

    Answers, by subject: least proven, least in the middle with its time, and whether any part stayed open.
    """
    proven, reached = np.full(subjects, np.inf), np.full(subjects, np.inf)
    time, is_open = np.zeros(subjects), np.zeros(subjects, bool)
    for piece in pieces:
        first = 0 if isinstance(piece, Polynomial) and len(pieces) > 3 else FIRST_LEVEL
        waiting = [(first, np.arange(2**first))]
        while waiting:
            level, index = waiting.pop()
            if len(index) > MOST_AT_ONCE:
                waiting += [(level, index[:MOST_AT_ONCE]), (level, index[MOST_AT_ONCE:])]
                continue
            parts = Parts(piece, level, index)
            held, middle = look(parts)  # [subject, part]
            worst = middle.argmin(1)
            least = middle[np.arange(subjects), worst]
            nearer = least < reached
            reached = np.where(nearer, least, reached)
            time = np.where(nearer, piece.start + parts.middle[worst], time)
            # What is broken somewhere needs no proof elsewhere.
            is_left = ~(held >= 0) & (reached >= 0)[:, None]
            if level >= LAST_LEVEL:
                is_open |= is_left.any(1)
                is_left[:] = False
            proven = np.minimum(proven, np.where(is_left, np.inf, held).min(1))
            left = index[is_left.any(0)]
            if len(left):
                waiting.append((level + 1, np.concatenate([2 * left, 2 * left + 1])))
    return proven, reached, time, is_open


# ---------------------------------------------------------------- bodies

MOST_VERTICES = 400  # that are taken as they are
NEAR_HULL = 5e-5  # m: vertices nearer to the hull of the others add nothing to it but this much all around
SEARCHES = 60


def reduced(vertices, radius):
    """Fewer vertices whose hull, thickened by the radius, holds the old one."""
    if len(vertices) <= MOST_VERTICES:
        return vertices, radius
    k = np.arange(MOST_VERTICES) + 0.5
    z, angle = 1 - 2 * k / MOST_VERTICES, math.pi * (1 + 5**0.5) * k
    across = np.sqrt(1 - z * z)
    outermost = lambda along: np.concatenate([(part @ vertices.T).argmax(1) for part in np.array_split(along, 20)])
    kept = np.unique(outermost(np.c_[across * np.cos(angle), across * np.sin(angle), z]))
    others = np.setdiff1d(np.arange(len(vertices)), kept)
    for _ in range(8):
        left, along = [], []
        for part in np.array_split(others, len(others) // MOST_AT_ONCE + 1):
            points, turn = np.repeat(vertices[part, None], 2, 1), np.tile(np.eye(3), (len(part), 2, 1, 1))
            n, _, seen = separate(vertices[kept], np.zeros((1, 3)), turn, points, np.full(len(part), NEAR_HULL))
            outside = seen >= NEAR_HULL
            left, along = left + [part[outside]], along + [-n[outside]]
        others, along = np.concatenate(left), np.concatenate(along)
        more = np.setdiff1d(outermost(along), kept) if len(others) else others
        if not len(more):
            break
        kept = np.union1d(kept, more)
        others = np.setdiff1d(others, kept)
    # Those of which it was not seen that they are near the hull stay.
    return vertices[np.union1d(kept, others)], radius + NEAR_HULL * (1 + 1e-9)


def separate(a, b, rotation, position, enough):
    """For each part: a unit vector n, what it proves of n.(x - y), x in a, y in b at both poses, and a distance seen.

    [Gilbert, Johnson, Keerthi 1988], with the nearest point among at most eight differences found by exchange.
    rotation: [part, end, 3, 3], position: [part, end, 3], of b in the frame of a. Ends where `enough` is proven, or
    where it is seen that less is there.
    """
    count, keep = len(position), 8
    size = np.abs(a).max() + np.abs(b).max() * 2 + np.abs(position).max()
    n = a.mean(0) - (position + np.einsum("peij,j->pei", rotation, b.mean(0))).mean(1)
    best, proven, seen = np.tile([0.0, 0.0, 1.0], (count, 1)), np.full(count, -np.inf), np.full(count, np.inf)
    differences, weights = np.zeros((count, keep, 3)), np.zeros((count, keep))
    is_filled = np.zeros((count, keep), bool)
    active = np.arange(count)
    for turn in range(SEARCHES):
        m = n[active]
        length = np.sqrt((m * m).sum(1))
        m = np.where(length[:, None] > 1e-12, m / np.maximum(length, 1e-12)[:, None], [0.0, 0.0, 1.0])
        on_a = (m @ a.T).argmin(1)
        own = np.einsum("peij,pi->pej", rotation[active], m)
        heights = own @ b.T + np.einsum("pei,pi->pe", position[active], m)[:, :, None]
        flat = heights.reshape(len(active), -1)
        on_b = flat.argmax(1)
        end, vertex = on_b // len(b), on_b % len(b)
        floor = (m * a[on_a]).sum(1) - flat[np.arange(len(active)), on_b] - 64 * E * size
        better = floor > proven[active]
        proven[active] = np.where(better, floor, proven[active])
        best[active] = np.where(better[:, None], m, best[active])
        difference = a[on_a] - np.einsum("pij,pj->pi", rotation[active, end], b[vertex]) - position[active, end]
        slot = weights[active].argmin(1)
        d, w = differences[active], weights[active]
        i = np.arange(len(active))
        w[i, slot] = 1.0 if turn == 0 else 0.0
        w /= w.sum(1, keepdims=True)
        d[i, slot], is_filled[active, slot] = difference, True
        filled = is_filled[active]
        gram = np.einsum("pki,pli->pkl", d, d)
        for _ in range(2 * keep):
            slope = np.einsum("pkl,pl->pk", gram, w)
            up = np.where(filled, slope, np.inf).argmin(1)
            down = np.where(w > 0, slope, -np.inf).argmax(1)
            bend = gram[i, up, up] + gram[i, down, down] - 2 * gram[i, up, down]
            by = np.where(bend > 0, (slope[i, down] - slope[i, up]) / np.maximum(bend, TINY), 0.0)
            by = np.clip(by, 0, w[i, down])
            w[i, up] += by
            w[i, down] -= by
        differences[active], weights[active] = d, w
        n[active] = np.einsum("pk,pki->pi", w, d)
        seen[active] = np.minimum(seen[active], np.sqrt((n[active] ** 2).sum(1)))
        is_told = (proven[active] >= enough[active]) | (seen[active] < enough[active])
        active = active[~(seen[active] - proven[active] < 1e-7 * size) & ~is_told]
        if not len(active):
            break
    return best, proven, seen


def ends(pose, count):
    """A pose at both ends of its parts, [part, end, ..], and how far its entries are off."""
    def of(x):
        x = x if isinstance(x, Form) else Form(float(x), 0.0, 0.0)
        return [np.broadcast_to(y, count) for y in (x.x0 - x.x1, x.x0 + x.x1, x.r + 4 * E * x.size())]

    rotation = np.array([[of(x) for x in row] for row in pose[0]])  # [3, 3, low/high/off, part]
    position = np.array([of(x) for x in pose[1]])
    rotation, position = np.moveaxis(rotation, (2, 3), (1, 0)), np.moveaxis(position, (1, 2), (1, 0))
    return rotation[:, :2], position[:, :2], rotation[:, 2], position[:, 2]


def planes_of(space, place):
    """Half-spaces n.x >= offset of walls and boxes, by name, each with the links that it is for."""
    planes, walls, boxes = {}, space.get("walls") or [], space.get("boxes") or []
    named = lambda what, k, all_: f"the {what}" if len(all_) == 1 and not place else f"{what} {k + 1}{place}"
    for k, wall in enumerate(walls):
        normal = np.array(wall["normal"], float)
        normal /= np.linalg.norm(normal)
        offset = float(normal @ np.array(wall["point"], float))
        planes[named("wall", k, walls)] = ((normal, offset), wall.get("links"))
    for k, box in enumerate(boxes):
        for i, axis in enumerate("xyz"):
            for sign, end, key in ((1.0, "least", "low"), (-1.0, "greatest", "high")):
                plane = (sign * np.eye(3)[i], sign * float(box[key][i]))
                planes[f"the {end} {axis} of {named('box', k, boxes)}"] = (plane, box.get("links"))
    return planes


def gap_rows(robot, certificate, theirs, mine, floor):
    """What the certificate names, and what the limits file asks for: (kind, text, bound, body, other body or plane)."""
    rows, unknown = [], []
    bodies = {name: (k, [reduced(*solid) for solid in solids]) for name, (k, solids) in robot.bodies.items()}
    for k, link in enumerate(robot.links):
        if not any(name in bodies for name, _ in link.origins):
            bodies[link.name] = (k, [(place[None], 0.0) for _, place in link.origins])
    up, planes = (np.array([0, 0, 1.0]), floor), planes_of(theirs, "")
    if floor is not None:
        planes["the floor"] = (up, None)
    for row in certificate:
        subject, found = row["subject"], None
        if row["limit"] == "region":
            body, _, place = subject.partition(" at ")
            if body in bodies and place in planes:
                found = (subject, 0.0, body, planes[place][0])
        elif row["limit"] == "distance":
            splits = [(subject[: m.start()], subject[m.end() :]) for m in re.finditer(" and ", subject)]
            pair = next((s for s in splits if s[0] in bodies and s[1] in bodies), None)
            if pair:
                found = (subject, float(row["bound"]) - float(row.get("margin") or 0.0), *pair)
        else:
            continue
        rows.append((row["limit"], *found)) if found else unknown.append(f"{row['limit']} of {subject}")
    # The limits file asks for all that move, whatever the certificate names.
    asked = planes_of({key: [x for x in mine.get(key) or [] if x not in (theirs.get(key) or [])]
                       for key in ("walls", "boxes")}, " of the limits file")
    if isinstance(mine.get("floor"), (int, float)):
        asked["the floor"] = (up, None)
    for place, (plane, links) in asked.items():
        for name, (carrier, _) in bodies.items():
            is_meant = carrier is not None and (not links or name in links or robot.links[carrier].name in links)
            text = f"{name} at {place}"
            if is_meant and all(row[1] != text for row in rows):
                rows.append(("region", text, 0.0, name, plane))
    return rows, unknown, bodies


def prove_gap(robot, pieces, names, bodies, row, margins):
    """The room of a gap above its bound, with what errors of joints and bodies take of it."""
    _, _, bound, body, other = row
    has_margins = margins.bodies > 0 or any(margins.joints.values())
    carrier, solids = bodies[body]
    # What is seen between bodies that were thickened may be less than is there.
    thickened = sum(NEAR_HULL * any(len(v) > MOST_VERTICES for v, _ in robot.bodies.get(name, (0, []))[1])
                    for name in (body, other) if isinstance(name, str)) * (1 + 1e-9)
    is_plane = not isinstance(other, str)
    against, opposite = (None, []) if is_plane else bodies[other]
    own, theirs = robot.chain(carrier), robot.chain(against)
    common = set(own) & set(theirs)
    moving = [[k for k in chain if k not in common] for chain in (own, theirs)]
    lost = 2 * margins.bodies + sum(margins.lost(robot, *x) for x in zip(moving, (solids, opposite)) if not is_plane)

    def pose(chain, q):
        found = IDENTITY
        for k in reversed([k for k in chain if k not in common]):
            found = compose(found, joint_pose(robot.links[k], q))
        return found

    def off(vertices, turn, shift, n):
        return (np.abs(n) * (turn @ np.abs(vertices).max(0) + shift)).sum(1)

    def guarded(seen, parts):
        # What is seen is a mean of two poses; only that of a short part is a pose of the motion.
        return np.where(parts.half > 1e-5, np.maximum(seen, 1e-9), seen)[None]

    def look(parts):
        q, count = parts.forms(0, names, margins.joints if is_plane else None), len(parts.middle)
        (turn, shift) = pose(own, q)
        held, seen = np.full(count, np.inf), np.full(count, np.inf)
        if is_plane:
            n, height = other
            turn, shift, turn_off, shift_off = ends((turn, shift), count)
            for vertices, radius in solids:
                least = (np.einsum("peij,vj,i->pev", turn, vertices, n) + (shift @ n)[:, :, None]).min(2)
                away = off(vertices, turn_off, shift_off, np.tile(n, (count, 1))) + 1e-12 + radius + margins.bodies
                held = np.minimum(held, least.min(1) - away - height)
                seen = np.minimum(seen, least.mean(1) - (away if has_margins else radius) - height + thickened)
            return held[None], guarded(seen, parts)
        back = transposed(turn)
        inverse = (back, [-x for x in turned(back, shift)])
        turn, shift, turn_off, shift_off = ends(compose(inverse, pose(theirs, q)), count)
        for a, ra in solids:
            for b, rb in opposite:
                # The balls about the vertices tell cheaply what is far.
                far = np.sqrt(((a.mean(0) - shift - np.einsum("peij,j->pei", turn, b.mean(0))) ** 2).sum(2)).min(1)
                balls = sum(np.sqrt(((x - x.mean(0)) ** 2).sum(1)).max() for x in (a, b)) + ra + rb + bound
                away = (turn_off @ np.abs(b).max(0) + shift_off).sum(1) + 1e-12 + lost
                proven, reached = far - balls - 2 * away - 1e-3, far - balls
                near = np.flatnonzero(proven < 0)
                if len(near):
                    enough = bound + ra + rb + away[near]
                    _, p, s = separate(a, b, turn[near], shift[near], enough)
                    proven[near], reached[near] = p - enough, s - enough + thickened + (0 if has_margins else 2 * away[near])
                held, seen = np.minimum(held, proven), np.minimum(seen, reached)
        return held[None], guarded(seen, parts)

    return prove(pieces, look, 1)


# ---------------------------------------------------------------- limits and torques

KINDS = ("position", "velocity", "acceleration", "jerk")
ALONE = "the motion's file alone"


def positive(x):
    return float(x) if isinstance(x, (int, float)) and math.isfinite(x) and x > 0 else None


def held_limits(robot, motion, file):
    """By coordinate and kind: least and greatest, the tightest of all three, and where a limit stands."""
    found = {}
    for joint in motion["joints"]:
        name, own = joint["coordinate"], joint.get("limits") or {}
        given = {**(file.get("all") or {}), **((file.get("coordinates") or {}).get(name) or {})}
        slowed = given.get("slowed") or 1.0
        for power, kind in enumerate((*KINDS, "effort", "power")):
            bounds = []
            sources = (("the description", robot.limits[name]), ("the limits file", given), (ALONE, own))
            for origin, source in sources:
                x = source.get(kind)
                if kind == "position":
                    if x and x[0] <= x[1] and max(map(abs, x)) <= 1e3:
                        bounds.append((float(x[0]), float(x[1]), origin))
                elif positive(x):
                    factor = slowed**power if origin != ALONE and kind in KINDS else 1.0
                    bounds.append((-x * factor, x * factor, origin))
            if bounds:
                low, high = max(b[0] for b in bounds), min(b[1] for b in bounds)
                found[name, kind] = (low, high, bounds[0][2])
    return found


def prove_series(robot, pieces, names, limits):
    """Rows of position and its derivatives."""
    all_ = [(k, d) for k in range(len(names)) for d in range(4) if (names[k], KINDS[d]) in limits]
    rows = [(k, d, *limits[names[k], KINDS[d]]) for k, d in all_]
    at, order, low, high = (np.array([row[i] for row in rows]) for i in range(4))

    def look(parts):
        least, greatest = (np.array(x) for x in zip(*(parts.range(d) for d in range(4))))
        middle = np.array([x for x, _ in parts.derivatives[:4]])
        # Locked coordinates have no room: what rounding takes is no break.
        room = lambda a, b: np.minimum(a[order, at] - low[:, None], high[:, None] - b[order, at]) + 1e-12
        return room(least, greatest), room(middle, middle)

    return [(KINDS[d], names[k], origin) for k, d, _, _, origin in rows], prove(pieces, look, len(rows))


def prove_efforts(robot, pieces, names, limits, share):
    rows = [(k, kind) for k, name in enumerate(names) for kind in ("effort", "power") if (name, kind) in limits]

    def look(parts):
        q, dq, ddq = (parts.forms(d, names) for d in range(3))
        tau, held, seen = torques(robot, q, dq, ddq), [], []
        for k, kind in rows:
            viscous, coulomb, offset = robot.friction[names[k]]
            total, bound = tau[names[k]] + dq[names[k]] * viscous + offset, share * limits[names[k], kind][1]
            total = total if isinstance(total, Form) else Form(np.full(len(parts.middle), float(total)), 0.0, 0.0)
            if kind == "power":
                # Dry friction to the worse side.
                speed = dq[names[k]]
                used = (total * speed).magnitude() + coulomb * speed.magnitude()
                at = np.maximum(np.abs(total.x0) - total.r, 0) * np.maximum(np.abs(speed.x0) - speed.r, 0)
            else:
                used, at = total.magnitude() + coulomb, np.abs(total.x0) + coulomb - total.r
            held.append(bound - used * (1 + 4 * E) - SMALL_TORQUE + 0 * parts.middle)
            seen.append(bound - at + 0 * parts.middle)
        return np.array(held), np.array(seen)

    return [(kind, names[k], limits[names[k], kind][2]) for k, kind in rows], prove(pieces, look, len(rows))


# ---------------------------------------------------------------- the program


def tell(rows, result, out):
    proven, reached, time, is_open = result
    good = True
    for k, (kind, subject, origin) in enumerate(rows):
        if reached[k] < 0:
            out(f"BROKEN: {kind} of {subject}: beyond by {-reached[k]:.6g} at {time[k]:.4f} s")
        elif is_open[k] or not proven[k] >= 0:
            out(f"NOT PROVEN: {kind} of {subject}: room {reached[k]:.6g} at {time[k]:.4f} s")
        good = good and reached[k] >= 0 and not is_open[k] and proven[k] >= 0
    return good


def check(model, motion_file, limits_file=None, as_given=False, out=print):
    """Whether all that the certificate names is proven."""
    robot = (read_urdf if str(model).endswith((".urdf", ".xml")) else read_description)(model, as_given)
    motion = parse_yaml(pathlib.Path(motion_file).read_text())
    file = parse_yaml(pathlib.Path(limits_file).read_text()) if limits_file else {}
    names = [joint["coordinate"] for joint in motion["joints"]]
    if sorted(names) != sorted(robot.coordinates):
        raise Fault(f"{motion_file}: joints {names}; the description has {robot.coordinates}")
    flat = [x for j in motion["joints"] for key in ("cosine", "sine", "control_points") for x in (j.get(key) or [])]
    flat += [j["centre"] for j in motion["joints"]]
    if not all(isinstance(x, (int, float)) and math.isfinite(x) for x in flat):
        raise Fault(f"{motion_file}: a coefficient is no number")
    margins = Margins(file, motion, names)
    pieces, limits = pieces_of(motion), margins.narrow(held_limits(robot, motion, file))
    share = float(motion.get("effort_share", 1.0))
    share = share if 0 < share <= 1 else 1.0
    rows, result = prove_series(robot, pieces, names, limits)
    good = tell(rows, result, out)
    told = [f"{sum(row[0] == kind for row in rows)} {kind}" for kind in KINDS]
    stopping, stops = stopping_limits(motion)
    if stops:
        still, result = prove_series(robot, pieces, names, stopping)
        good = tell([("stopping", *row[1:]) for row in still], result, out) and good
        told.append(stops)
    unseen = []
    if robot.has_dynamics and any(kind in ("effort", "power") for _, kind in limits):
        efforts, result = prove_efforts(robot, pieces, names, limits, share)
        good = tell(efforts, result, out) and good
        if margins.payload:
            loaded, result = prove_efforts(margins.loaded(robot), pieces, names, limits, share)
            good = tell([(f"{kind} with the payload", *row) for kind, *row in loaded], result, out) and good
        rows += efforts
        told += [f"{sum(row[0] == kind for row in efforts)} {kind}" for kind in ("effort", "power")]
    else:
        unseen.append("efforts: the description has no inertial parameters, or nothing limits them")
    unseen += [f"{kind} of {name}: no limit" for name in names for kind in ("effort",) if (name, kind) not in limits]
    mine, theirs = file.get("space") or {}, motion.get("space") or {}
    floors = [float(x) for x in (mine.get("floor"), theirs.get("floor")) if isinstance(x, (int, float))]
    certificate = motion.get("certificate") or []
    gaps, unknown, bodies = gap_rows(robot, certificate, theirs, mine, max(floors) if floors else None)
    good = good and not unknown
    for text in unknown:
        out(f"NOT PROVEN: {text}: the certificate names what description and limits do not have")
    bounds = []
    for row in gaps:
        if row[0] == "distance":
            row = (*row[:2], max(row[2], float(mine.get("distance") or 0.0)), *row[3:])
            bounds.append(row[2])
        found = prove_gap(robot, pieces, names, bodies, row, margins)
        if not found[0].min() >= 0 and row[0] == "distance":  # Pieces of a mesh may prove what its hull does not.
            cut = {b: (robot.bodies[b][0], [reduced(*s) for s in in_pieces(robot, b)]) for b in row[3:]}
            found = prove_gap(robot, pieces, names, cut, row, margins)
        good = tell([(row[0], row[1], "")], found, out) and good
    told += [f"{sum(row[0] == kind for row in gaps)} {kind}" for kind in ("distance", "region")]
    # What nobody looked at.
    named = {frozenset(row[3:]) for row in gaps if row[0] == "distance"}
    movable = [(a, b) for k, a in enumerate(sorted(robot.bodies)) for b in sorted(robot.bodies)[:k]
               if robot.bodies[a][0] != robot.bodies[b][0] and frozenset((a, b)) not in named]
    unseen += [f"distance of {a} and {b}: not in the certificate" for a, b in movable]
    standing = {row[3] for row in gaps if row[0] == "region" and row[1].endswith(" at the floor")}
    if floors:
        unseen += [f"{name} at the floor: no row (it does not move towards it, or is left out)"
                   for name in sorted(bodies) if bodies[name][0] is not None and name not in standing]
    unseen += [f"shape of {text}" for text in robot.unread]
    unseen += [] if floors else ["a floor: neither the limits file nor the motion has one"]
    unseen += margins.unseen()
    alone = sorted({row[0] for row in rows if row[2] == ALONE})
    if alone:
        unseen.append(f"limits of {', '.join(alone)} are as the motion's file has them: nothing else gives one")
    if bounds:
        unseen.append(f"distances are held to {min(bounds):g} to {max(bounds):g} m, as the certificate has them")
    if motion.get("identified"):
        unseen.append("torques of an estimate: those of the description are held")
    unseen += [
        "the way to the first pose and from the last",
        "what is no part of the description: cables; torques and velocities of tracking errors",
        "fingerprint, criterion and parameters of the motion's file",
    ]
    for text in unseen:
        out(f"NOT looked at: {text}")
    out(f"{'proven' if good else 'NOT proven'}, between samples too: {', '.join(t for t in told if t[0] != '0')}"
        f"; efforts to {share:g} of their limits")
    return good


def main(arguments):
    as_given = "--as-given" in arguments
    arguments = [a for a in arguments if a != "--as-given"]
    limits = None
    if "--limits" in arguments:
        k = arguments.index("--limits")
        limits = arguments[k + 1]
        del arguments[k : k + 2]
    if len(arguments) != 2:
        print(__doc__.strip())
        return 2
    try:
        return 0 if check(*arguments, limits, as_given) else 1
    except (Fault, OSError, KeyError, TypeError, ValueError, IndexError, SyntaxError, xml.ParseError) as fault:
        print(f"cannot be read: {type(fault).__name__}: {fault}")
        return 2


if __name__ == "__main__":
    np.seterr(over="ignore", invalid="ignore")
    sys.exit(main(sys.argv[1:]))
