"""Meshes cut into pieces of which each is held to its hull, with nothing of rist. Needs numpy.

A plane cuts the triangles that it meets. A half has the surface on its side with the rim of the cut, so that its hull
holds all of the solid there. So the hulls of all pieces hold the solid, however it is cut: here in the middle of its
longest side, again and again.
"""

import re
import struct

import numpy as np

TIMES = 5  # that a mesh is cut at most
SMALLEST = 0.02  # m: a piece that is not longer is not cut
ROUNDING = 1e-12  # m: what cut edges may be off


def triangles(file):
    """[triangle, corner, 3] of a mesh in STL or OBJ; None of other formats."""
    data = file.read_bytes()
    if file.suffix.lower() == ".obj":
        corners, found = [], []
        for words in (line.split() for line in data.decode(errors="replace").splitlines()):
            if words[:1] == ["v"]:
                corners.append([float(x) for x in words[1:4]])
            elif words[:1] == ["f"]:
                numbers = [int(word.split("/")[0]) for word in words[1:]]
                face = [corners[k - 1 if k > 0 else k] for k in numbers]
                found += [[face[0], *pair] for pair in zip(face[1:], face[2:])]
        return np.array(found).reshape(-1, 3, 3)
    if file.suffix.lower() == ".stl":
        count = struct.unpack_from("<I", data, 80)[0] if len(data) >= 84 else 0
        if len(data) == 84 + 50 * count:
            kind = np.dtype([("n", "<f4", 3), ("v", "<f4", (3, 3)), ("a", "<u2")])
            return np.frombuffer(data, kind, count, 84)["v"].astype(float)
        words = re.findall(rb"vertex\s+(\S+)\s+(\S+)\s+(\S+)", data)
        return np.array([[float(x) for x in word] for word in words]).reshape(-1, 3, 3)
    return None


def clipped(found, axis, at, side):
    """What of the triangles has side * x[axis] <= side * at. A face in the plane belongs to the half below."""
    beyond = side * (found[:, :, axis] - at)
    if side < 0:
        found, beyond = found[~(beyond == 0).all(1)], beyond[~(beyond == 0).all(1)]
    whole, crossing = (beyond <= 0).all(1), ~(beyond <= 0).all(1) & ~(beyond > 0).all(1)
    cut = []
    for corners, heights in zip(found[crossing], beyond[crossing]):
        rim = []
        for k in range(3):
            a, b, x, y = heights[k], heights[(k + 1) % 3], corners[k], corners[(k + 1) % 3]
            if a <= 0:
                rim.append(x)
            if a * b < 0:
                on_plane = x + a / (a - b) * (y - x)
                on_plane[axis] = at
                rim.append(on_plane)
        cut += [[rim[0], *pair] for pair in zip(rim[1:], rim[2:])]
    return np.concatenate([found[whole], np.array(cut).reshape(-1, 3, 3)])


def pieces(found, times=TIMES):
    """(vertices, radius) of the pieces: together their hulls, thickened by the radius, hold the solid."""
    vertices = found.reshape(-1, 3)
    size = np.ptp(vertices, axis=0)
    axis = size.argmax()
    if times and size[axis] > SMALLEST:
        at = vertices[:, axis].min() + 0.5 * size[axis]
        halves = [clipped(found, axis, at, side) for side in (1.0, -1.0)]
        if all(map(len, halves)):
            return [piece for half in halves for piece in pieces(half, times - 1)]
    return [(np.unique(vertices, axis=0), ROUNDING)]
