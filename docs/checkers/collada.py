"""The vertices of a Collada file (.dae), m, where its scene puts them; axes as they stand in the file. Needs numpy."""

import math
import xml.etree.ElementTree as xml

import numpy as np

MOST_INSTANCES = 10_000


def tag(node):
    return node.tag.rpartition("}")[2]


def child(node, name):
    return next((n for n in node if tag(n) == name), None)


def transform(node):
    x, found = [float(word) for word in (node.text or "").split()], np.eye(4)
    kind = tag(node)
    if kind == "matrix":
        return np.array(x).reshape(4, 4)
    if kind == "translate":
        found[:3, 3] = x
    elif kind == "scale":
        found[:3, :3] = np.diag(x)
    else:
        length = math.hypot(*x[:3])
        if length > 0:
            u, angle = np.array(x[:3]) / length, math.radians(x[3])
            k = np.array([[0, -u[2], u[1]], [u[2], 0, -u[0]], [-u[1], u[0], 0]])
            found[:3, :3] += math.sin(angle) * k + (1 - math.cos(angle)) * k @ k
    return found


def of_faces(mesh, points):
    """The points that faces use; all where there is no face."""
    used = []
    for faces in mesh:
        if tag(faces) in ("triangles", "polylist", "polygons", "tristrips", "trifans"):
            inputs = [(n.get("semantic"), int(n.get("offset", 0))) for n in faces if tag(n) == "input"]
            start, stride = dict(inputs)["VERTEX"], 1 + max(offset for _, offset in inputs)
            for corners in faces.iter():
                if tag(corners) == "p":
                    used += (corners.text or "").split()[start::stride]
    return points[np.unique(np.array(used, int))] if used else points


def vertices(data):
    """An array of points, or why there is none."""
    try:
        root = xml.fromstring(data)
    except xml.ParseError as fault:
        return f"it is no XML: {fault}"
    found, count, ids = [], 0, {}
    for node in root.iter():
        if node.get("id"):
            ids.setdefault(node.get("id"), node)
    target = lambda node, key: ids[node.get(key).removeprefix("#")]

    def geometry(node, here):
        source = target(next(n for n in child(child(node, "mesh"), "vertices") if n.get("semantic") == "POSITION"), "source")
        numbers = np.array((child(source, "float_array").text or "").split(), float)
        technique = child(source, "technique_common")
        accessor = child(technique, "accessor") if technique is not None else None
        get = lambda key, default: int(accessor.get(key, default)) if accessor is not None else default
        stride, offset = get("stride", 3), get("offset", 0)
        points = [numbers[k : k + 3] for k in range(offset, len(numbers) - 2, stride)]
        points = np.array(points[: get("count", len(points))]).reshape(-1, 3)
        points = of_faces(child(node, "mesh"), points)
        found.append(points @ here[:3, :3].T + here[:3, 3])

    def visit(node, here):
        nonlocal count
        count += 1
        if count > MOST_INSTANCES:
            raise ValueError("more instances than are read")
        for part in node:
            kind = tag(part)
            if kind in ("matrix", "translate", "rotate", "scale"):
                here = here @ transform(part)
            elif kind == "node":
                visit(part, here)
            elif kind == "instance_node":
                visit(target(part, "url"), here)
            elif kind == "instance_geometry":
                geometry(target(part, "url"), here)
            elif kind in ("lookat", "skew", "instance_controller"):
                raise ValueError(f"<{kind}> is not read")

    try:
        scene, library = child(root, "scene"), child(root, "library_visual_scenes")
        shown = child(scene, "instance_visual_scene") if scene is not None else None
        if shown is not None:
            visit(target(shown, "url"), np.eye(4))
        elif library is not None:
            visit(child(library, "visual_scene"), np.eye(4))
        else:
            for node in root.iter():
                if tag(node) == "geometry":
                    geometry(node, np.eye(4))
        asset = child(root, "asset")
        unit = child(asset, "unit") if asset is not None else None
        meter = float(unit.get("meter", 1.0)) if unit is not None else 1.0
        return meter * np.concatenate(found) if found else np.zeros((0, 3))
    except (AttributeError, IndexError, KeyError, StopIteration, RecursionError, ValueError) as fault:
        return f"it is no Collada that this program reads ({type(fault).__name__}: {fault})"
