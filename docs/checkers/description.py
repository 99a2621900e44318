"""Reads what the checkers check: descriptions in URDF and YAML, and the YAML of rist, with nothing of rist.

A robot is a list of links that move, each after the one that carries it; links fixed to another are part of it.
Formats: docs/files.md, docs/motion-and-plan.md, https://wiki.ros.org/urdf/XML. Needs numpy.
"""

import ast
import math
import pathlib
import re
import struct
import xml.etree.ElementTree as xml

import numpy as np

import collada
import pieces


class Fault(Exception):
    """A file that cannot be read."""


# ---------------------------------------------------------------- YAML, as far as rist and people write it here


def parse_yaml(text):
    """Block and flow mappings and sequences, scalars, quotes, comments, folded text."""
    lines = []
    for raw in text.replace("\t", "  ").split("\n"):
        line = strip_comment(raw).rstrip()
        if line.strip() and line.strip() not in ("---", "..."):
            lines.append((len(line) - len(line.lstrip()), line.strip()))
    value, at = parse_block(lines, 0, lines[0][0] if lines else 0)
    if at != len(lines):
        raise Fault(f"no YAML that this program reads: `{lines[at][1][:60]}`")
    return value


def strip_comment(line):
    if "#" not in line:
        return line
    quote = None
    for k, c in enumerate(line):
        if quote:
            quote = None if c == quote else quote
        elif c in "\"'":
            quote = c
        elif c == "#" and (k == 0 or line[k - 1] in " \t"):
            return line[:k]
    return line


KEY = re.compile(r"""("[^"]*"|'[^']*'|[^\s\[\]{},"'#][^\[\]{},#]*?):(?:\s+(.*))?$""")


def parse_block(lines, at, indent):
    if at >= len(lines):
        return None, at
    if lines[at][1] == "-" or lines[at][1].startswith("- "):
        found = []
        while at < len(lines) and lines[at][0] == indent and (lines[at][1] == "-" or lines[at][1].startswith("- ")):
            rest = lines[at][1][1:].strip()
            if not rest:
                value, at = parse_block(lines, at + 1, lines[at + 1][0])
            elif (KEY.match(rest) and rest[0] not in "{[\"'") or rest == "-" or rest.startswith("- "):
                inner = indent + len(lines[at][1]) - len(rest)
                lines[at] = (inner, rest)
                value, at = parse_block(lines, at, inner)
            else:
                value, at = parse_value(lines, at, rest, indent)
            found.append(value)
        return found, at
    found = {}
    while at < len(lines) and lines[at][0] == indent:
        match = KEY.match(lines[at][1])
        if not match:
            raise Fault(f"no YAML that this program reads: `{lines[at][1][:60]}`")
        key, rest = match[1].strip("\"'"), (match[2] or "").strip()
        if key in found:
            raise Fault(f"`{key}` stands twice")
        if rest:
            found[key], at = parse_value(lines, at, rest, indent)
        elif at + 1 < len(lines) and (
            lines[at + 1][0] > indent or (lines[at + 1][0] == indent and lines[at + 1][1].startswith("-"))
        ):
            found[key], at = parse_block(lines, at + 1, lines[at + 1][0])
        else:
            found[key], at = None, at + 1
    return found, at


def parse_value(lines, at, text, indent):
    """A scalar or a flow value, which may go on in lines further in."""
    at += 1
    if text in (">-", ">", "|", "|-"):
        words = []
        while at < len(lines) and lines[at][0] > indent:
            words.append(lines[at][1])
            at += 1
        return " ".join(words), at
    if text[0] in "[{\"'":
        # Flow values and quoted text end where they are closed.
        while at < len(lines) and not is_closed(text):
            text += " " + lines[at][1]
            at += 1
        value, rest = parse_flow(text)
        if rest.strip():
            raise Fault(f"no YAML that this program reads: `{rest[:60]}`")
        return value, at
    while at < len(lines) and lines[at][0] > indent:
        text += " " + lines[at][1]
        at += 1
    return scalar(text), at


def is_closed(text):
    depth, quote = 0, None
    for c in text:
        if quote:
            quote = None if c == quote else quote
        elif c in "\"'":
            quote = c
        else:
            depth += (c in "[{") - (c in "]}")
    return depth <= 0 and quote is None


def parse_flow(text):
    text = text.lstrip()
    if text[:1] in ("[", "{"):
        is_list, close = text[0] == "[", "]" if text[0] == "[" else "}"
        found, text = ([] if is_list else {}), text[1:].lstrip()
        while not text.startswith(close):
            if not text:
                raise Fault("a bracket is not closed")
            key = None
            if not is_list:
                match = re.match(r"\s*(\"[^\"]*\"|'[^']*'|[^:,\[\]{}]+?)\s*:(?=[\s\[{])", text)
                if not match:
                    raise Fault(f"no YAML that this program reads: `{text[:60]}`")
                key, text = match[1].strip("\"'"), text[match.end() :]
            value, text = parse_flow(text)
            if is_list:
                found.append(value)
            else:
                found[key] = value
            text = text.lstrip()
            if text.startswith(","):
                text = text[1:].lstrip()
        return found, text[1:]
    if text[:1] in "\"'" and text:
        end = text.index(text[0], 1)
        return text[1:end], text[end + 1 :]
    match = re.match(r"[^,\]}]*", text)
    return scalar(match[0].strip()), text[match.end() :]


def scalar(text):
    if text in ("null", "~", ""):
        return None
    if text in ("true", "false"):
        return text == "true"
    try:
        return int(text)
    except ValueError:
        pass
    try:
        return float(text.replace(".inf", "inf").replace(".nan", "nan"))
    except ValueError:
        return text


# ---------------------------------------------------------------- the robot


class Link:
    """A link that moves: the joint that carries it, its body about the origin of its frame, its shapes."""

    def __init__(self, name, parent, rotation, position, kind, axis):
        self.name, self.parent, self.rotation, self.position = name, parent, rotation, position
        self.kind, self.axis = kind, axis
        self.terms, self.offset = {}, 0.0  # q of the joint = offset + sum of multiples of coordinates
        self.mass, self.moment, self.inertia = 0.0, np.zeros(3), np.zeros((3, 3))
        self.has_rotor, self.rotor = False, 0.0  # a rotor inertia among its parameters, and its value
        self.origins = [(name, np.zeros(3))]  # of the frames that are fixed to it
        self.turns = [np.eye(3)]  # and how they are turned


class Robot:
    def __init__(self):
        self.links, self.coordinates, self.gravity, self.has_dynamics = [], [], np.array([0.0, 0.0, -9.81]), False
        self.limits, self.friction = {}, {}  # by coordinate
        self.bodies = {}  # by name: (link or None for the base, [(vertices in that link's frame, radius)])
        self.shapes = {}  # by name: [(path of the description, element, what puts points into that link's frame)]
        self.unread = []  # shapes that are not read, in sentences

    def chain(self, link):
        found = []
        while link is not None:
            found.append(link)
            link = self.links[link].parent
        return found


def meant(angle, as_given):
    """An angle near a multiple of 15 degrees is that multiple, as files.md says; where a decimal was cut off, too."""
    twelfths = round(angle * 12 / math.pi)
    away, step = abs(angle - twelfths * math.pi / 12), twelfths % 12
    if step not in (0, 2, 3, 4, 6, 8, 9, 10):
        return angle
    decimals = len(repr(angle).partition(".")[2])
    near = 1e-9 if as_given else max(5e-6, min(1e-4, 10.0**-decimals) if step in (0, 6) else 0.0)
    return twelfths * math.pi / 12 if away <= near else angle


def clean(matrix):
    """Sines of multiples of a quarter turn are exact."""
    return np.where(np.abs(matrix - np.round(matrix)) < 1e-14, np.round(matrix), matrix)


def rotation_of(rpy, as_given):
    (cr, sr), (cp, sp), (cy, sy) = [(math.cos(a), math.sin(a)) for a in (meant(x, as_given) for x in rpy)]
    return clean(
        np.array(
            [
                [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
                [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
                [-sp, cp * sr, cp * cr],
            ]
        )
    )


def skew(v):
    return np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])


def numbers(text, default):
    found = [float(x) for x in text.split()] if text else list(default)
    if len(found) != len(default) or not all(map(math.isfinite, found)):
        raise Fault(f"`{text}`: expected {len(default)} finite numbers")
    return np.array(found)


def read_urdf(path, as_given):
    root = xml.parse(path).getroot()
    robot, parts = Robot(), {link.get("name"): link for link in root.findall("link")}
    joints = {j.find("child").get("link"): j for j in root.findall("joint")}
    base = [name for name in parts if name not in joints]
    if len(base) != 1:
        raise Fault(f"{path}: there is not one base")

    def pose(element):
        origin = element.find("origin")
        xyz, rpy = (origin.get("xyz"), origin.get("rpy")) if origin is not None else ("", "")
        return rotation_of(numbers(rpy, (0, 0, 0)), as_given), numbers(xyz, (0, 0, 0))

    def attributes(joint, tag):
        found = joint.find(tag)
        return {} if found is None else found.attrib

    order = {}  # parents first, in the order of the file
    children = {}
    for joint in root.findall("joint"):
        children.setdefault(joint.find("parent").get("link"), []).append(joint.find("child").get("link"))
    place = {base[0]: (None, np.eye(3), np.zeros(3))}
    waiting = [base[0]]
    mimics = {}
    while waiting:
        name = waiting.pop()
        carrier, turn, shift = place[name]
        take_parts(robot, path, parts[name], name, carrier, turn, shift, pose)
        for child in reversed(children.get(name, [])):
            waiting.append(child)
        for child in children.get(name, []):
            joint = joints[child]
            own_turn, own_shift = pose(joint)
            own_turn, own_shift = clean(turn @ own_turn), shift + turn @ own_shift
            kind = joint.get("type")
            if kind == "fixed":
                place[child] = (carrier, own_turn, own_shift)
                continue
            if kind not in ("revolute", "continuous", "prismatic"):
                raise Fault(f"{path}: joints of type {kind} are not read")
            axis = numbers(attributes(joint, "axis").get("xyz"), (1, 0, 0))
            axis = clean(axis / np.linalg.norm(axis))
            link = Link(child, carrier, own_turn, own_shift, "prismatic" if kind == "prismatic" else "revolute", axis)
            robot.links.append(link)
            place[child] = (len(robot.links) - 1, np.eye(3), np.zeros(3))
            name_of, mimic = joint.get("name"), joint.find("mimic")
            order[name_of] = link
            limit, dynamics = attributes(joint, "limit"), attributes(joint, "dynamics")
            number = lambda key, given: float(given.get(key)) if given.get(key) else None
            position = (number("lower", limit) or 0.0, number("upper", limit) or 0.0)
            if mimic is not None:
                numbers_of = [float(mimic.get(key) or default) for key, default in (("multiplier", 1), ("offset", 0))]
                mimics[name_of] = (mimic.get("joint"), *numbers_of, None if kind == "continuous" else position)
                continue
            robot.coordinates.append(name_of)
            link.terms = {name_of: 1.0}
            robot.limits[name_of] = {"velocity": number("velocity", limit), "effort": number("effort", limit)}
            if kind != "continuous":
                robot.limits[name_of]["position"] = position
            robot.friction[name_of] = (number("damping", dynamics) or 0.0, number("friction", dynamics) or 0.0, 0.0)
    for name, (leader, multiple, offset, room) in mimics.items():
        while leader in mimics:
            above, m, o, _ = mimics[leader]
            leader, multiple, offset = above, multiple * m, offset + multiple * o
        order[name].terms, order[name].offset = {leader: multiple}, offset
        # The leader stays where its followers' own limits hold.
        if room and multiple and max(map(abs, room)) <= 1e3 and "position" in robot.limits[leader]:
            low, high = sorted((x - offset) / multiple for x in room)
            own = robot.limits[leader]["position"]
            both = (max(low, own[0]), min(high, own[1]))
            robot.limits[leader]["position"] = both if both[0] <= both[1] else own
    return robot


def take_parts(robot, path, part, name, carrier, turn, shift, pose):
    """The inertia and the shapes of a link of the file, in the frame of the link that carries it."""
    inertial = part.find("inertial")
    if carrier is not None:
        link = robot.links[carrier]
        if name != link.name:
            link.origins.append((name, shift))
            link.turns.append(turn)
        if inertial is not None:
            (own, centre), mass = pose(inertial), float(inertial.find("mass").get("value"))
            given = inertial.find("inertia")
            tensor = {k: float(given.get(k) or 0) for k in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")}
            tensor = np.array([[tensor["i" + "".join(sorted(a + b))] for b in "xyz"] for a in "xyz"])
            own, centre = turn @ own, shift + turn @ centre
            link.mass += mass
            link.moment = link.moment + mass * centre
            link.inertia = link.inertia + own @ tensor @ own.T - mass * skew(centre) @ skew(centre)
            robot.has_dynamics = robot.has_dynamics or mass > 0
    for collision in part.findall("collision"):
        own, place = pose(collision)
        shape = next(iter(collision.find("geometry")))
        found = solid(path, shape)
        if isinstance(found, str):
            robot.unread.append(f"{name}: {found}")
            continue
        put = lambda x, shift=shift + turn @ place, turn=(turn @ own).T: shift + x @ turn
        vertices, radius = found
        robot.bodies.setdefault(name, (carrier, []))[1].append((put(vertices), radius))
        robot.shapes.setdefault(name, []).append((path, shape, put))


def in_pieces(robot, name):
    """The solids of a body, its meshes in pieces where their triangles are read."""
    found = []
    for (path, shape, put), whole in zip(robot.shapes[name], robot.bodies[name][1]):
        given = pieces.triangles(mesh_file(path, shape.get("filename"))) if shape.tag == "mesh" else None
        if given is None or not len(given):
            found.append(whole)
        else:
            sized = put(given * numbers(shape.get("scale"), (1, 1, 1)))
            found += pieces.pieces(sized)
    return found


SIDES = 64  # of the prism about a cylinder


def solid(path, shape):
    """Vertices whose hull, thickened by a radius, holds the shape; or why it is not read."""
    if shape.tag == "box":
        half = 0.5 * numbers(shape.get("size"), (0, 0, 0))
        return np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * half, 0.0
    if shape.tag == "sphere":
        return np.zeros((1, 3)), float(shape.get("radius"))
    if shape.tag in ("cylinder", "capsule"):
        radius, half = float(shape.get("radius")), 0.5 * float(shape.get("length"))
        if shape.tag == "capsule":
            return np.array([[0, 0, half], [0, 0, -half]]), radius
        angle = 2 * math.pi * np.arange(SIDES) / SIDES
        ring = radius / math.cos(math.pi / SIDES) * np.stack([np.cos(angle), np.sin(angle)], 1)
        return np.concatenate([np.c_[ring, np.full(SIDES, z)] for z in (half, -half)]), 0.0
    if shape.tag == "mesh":
        vertices = mesh(path, shape.get("filename"))
        if isinstance(vertices, str):
            return vertices
        return vertices * numbers(shape.get("scale"), (1, 1, 1)), 0.0
    return f"shapes of kind {shape.tag} are not read"


def mesh_file(path, name):
    """The file of a mesh; None where it is not there."""
    folder = pathlib.Path(path).absolute().parent
    if name.startswith("file://"):
        places = [pathlib.Path(name[7:])]
    elif "://" in name:
        package, _, rest = name.split("://", 1)[1].partition("/")
        above = [folder, *folder.parents]
        places = [p for a in above for p in ([a / rest] if a.name == package else []) + [a / package / rest]]
    else:
        places = [folder / name]
    return next((p for p in places if p.is_file()), None)


def mesh(path, name):
    file = mesh_file(path, name)
    if file is None:
        return f"mesh {name}: it is not there"
    data = file.read_bytes()
    if file.suffix.lower() == ".obj":
        lines = [line.split() for line in data.decode(errors="replace").splitlines() if line.startswith("v ")]
        found = np.array([[float(x) for x in line[1:4]] for line in lines])
    elif file.suffix.lower() == ".stl":
        count = struct.unpack_from("<I", data, 80)[0] if len(data) >= 84 else 0
        if len(data) == 84 + 50 * count:
            triangles = np.frombuffer(data, np.dtype([("n", "<f4", 3), ("v", "<f4", (3, 3)), ("a", "<u2")]), count, 84)
            found = triangles["v"].reshape(-1, 3).astype(float)
        else:
            words = re.findall(rb"vertex\s+(\S+)\s+(\S+)\s+(\S+)", data)
            found = np.array([[float(x) for x in word] for word in words])
    elif file.suffix.lower() == ".dae":
        found = collada.vertices(data)
        if isinstance(found, str):
            return f"mesh {name}: {found}"
    else:
        return f"mesh {name}: meshes are read from .stl, .obj and .dae"
    return np.unique(found, axis=0) if len(found) else f"mesh {name}: it has no vertex"


def number_of(value, symbols):
    """(constant, multiples by coordinate) of an expression of numbers, pi, symbols and coordinates."""

    def of(node):
        if isinstance(node, ast.Constant):
            return float(node.value), {}
        if isinstance(node, ast.Name):
            if node.id == "pi":
                return math.pi, {}
            return (symbols[node.id], {}) if node.id in symbols else (0.0, {node.id: 1.0})
        if isinstance(node, ast.UnaryOp):
            sign = -1.0 if isinstance(node.op, ast.USub) else 1.0
            x, terms = of(node.operand)
            return sign * x, {k: sign * v for k, v in terms.items()}
        (x, a), (y, b) = of(node.left), of(node.right)
        if isinstance(node.op, (ast.Add, ast.Sub)):
            sign = 1.0 if isinstance(node.op, ast.Add) else -1.0
            return x + sign * y, {k: a.get(k, 0.0) + sign * b.get(k, 0.0) for k in [*a, *b]}
        if isinstance(node.op, ast.Mult) and not (a and b):
            return x * y, {**{k: v * y for k, v in a.items()}, **{k: v * x for k, v in b.items()}}
        if isinstance(node.op, ast.Div) and not b:
            return x / y, {k: v / y for k, v in a.items()}
        raise Fault(f"`{value}` is not read")

    return of(ast.parse(str(value), mode="eval").body)


def read_description(path, as_given):
    given = parse_yaml(pathlib.Path(path).read_text())
    if given.get("convention") != "khalil-kleinfinger":
        raise Fault(f"{path}: no description that this program reads")
    robot, symbols = Robot(), {}
    for name, value in (given.get("symbols") or {}).items():
        symbols[name] = number_of(value, symbols)[0]
    robot.gravity = np.array([number_of(x, symbols)[0] for x in given.get("gravity", [0, 0, -9.81])])
    place, known, turn = {"base": None}, given.get("standard_parameters") or {}, lambda x: meant(x, as_given)
    waiting = list(given["links"])
    while waiting:
        entry = next((e for e in waiting if str(e["antecedent"]) in place), None)
        if entry is None:
            raise Fault(f"{path}: a link has no antecedent")
        waiting.remove(entry)
        label = str(entry["link"])
        value = {k: number_of(entry.get(k, 0), symbols) for k in ("gamma", "b", "alpha", "d", "theta", "r")}
        kind = entry.get("joint") or ("prismatic" if value["r"][1] else "revolute" if value["theta"][1] else "fixed")
        moving = value["r"] if kind == "prismatic" else value["theta"]
        constant = {k: v[0] for k, v in value.items()}
        constant["r" if kind == "prismatic" else "theta"] = 0.0 if kind != "fixed" else moving[0]
        # Rz(gamma) Tz(b) Rx(alpha) Tx(d) Rz(theta) Tz(r), the moving one of the last two left out.
        gamma, theta = (rotation_of((0, 0, turn(constant[k])), as_given) for k in ("gamma", "theta"))
        alpha = rotation_of((turn(constant["alpha"]), 0, 0), as_given)
        shift = gamma @ (np.array([0, 0, constant["b"]]) + alpha @ np.array([constant["d"], 0, constant["r"]]))
        link = Link(entry.get("name") or f"link {label}", place[str(entry["antecedent"])],
                    clean(gamma @ alpha @ theta), shift, kind, np.array([0.0, 0.0, 1.0]))
        if kind != "fixed":
            link.terms = {k: v for k, v in moving[1].items() if v}
            link.offset = turn(moving[0]) if kind == "revolute" else moving[0]
        body = known.get(label)
        if body:
            robot.has_dynamics = True
            get = lambda key: number_of(body.get(key) or 0, symbols)[0]
            link.mass, link.moment = get("M"), np.array([get("MX"), get("MY"), get("MZ")])
            link.inertia = np.array([[get(min(a + b, b + a)) for b in "XYZ"] for a in "XYZ"])
        own, rotors = entry.get("rotor_inertia"), given.get("rotor_inertia") or "actuated"
        is_drive = (entry.get("drive") or "actuated") == "actuated" and kind != "fixed"
        is_meant = own is not None or rotors == "all" or (rotors == "actuated" and is_drive)
        link.has_rotor = kind != "fixed" and own != "none" and is_meant
        link.rotor = number_of((body or {}).get("IA") or 0, symbols)[0] if link.has_rotor else 0.0
        if isinstance(own, (int, float)):
            link.rotor = float(own)
        robot.links.append(link)
        place[label] = len(robot.links) - 1
        if (entry.get("drive") or "actuated") == "actuated" and len(link.terms) == 1:
            (name, multiple), = link.terms.items()
            if multiple == 1.0 and name not in robot.limits:
                robot.coordinates.append(name)
                limits, friction = dict(entry.get("limits") or {}), entry.get("friction") or {}
                for key in [k for k in limits if k.endswith("_deg")]:
                    scaled = np.radians(limits.pop(key))
                    limits[key[:-4]] = list(scaled) if scaled.ndim else float(scaled)
                robot.limits[name] = limits
                robot.friction[name] = tuple(float(friction.get(k) or 0) for k in ("viscous", "coulomb", "offset"))
    if any(k not in robot.limits for link in robot.links for k in link.terms):
        raise Fault(f"{path}: joints that a loop determines are not read")
    return robot
