"""What errors of a robot take of the room that a motion has, and how far stopping takes its joints.

Margins stand in the limits file (`margins`) and in the motion's file (`margins: errors`); the greater counts. A payload
of the limits file counts before that of the motion. Formats: docs/files.md, docs/motion-and-plan.md. Needs numpy.
"""

import copy
import math

import numpy as np

from description import Fault, skew

HELD_STILL = 1e-6  # rad (m): a joint with less room has none to lose
ROUNDING = 1e-5  # of a velocity that rist proves, relative
NAMES = {"encoder_zero": "encoder zero", "tracking": "tracking", "calibration": "calibration", "mesh": "mesh",
         "payload": "payload"}


class Margins:
    """By coordinate, rad (m); of each body, m; a payload that may be there; and the names of those that are given."""

    def __init__(self, file, motion, names):
        both = [file.get("margins") or {}, (motion.get("margins") or {}).get("errors") or {}]
        self.given = [key for key in NAMES if any(source.get(key) is not None for source in both)]

        def greatest(key, name=None):
            found = [source.get(key) or 0.0 for source in both]
            found = [float(x.get(name) or 0.0 if isinstance(x, dict) else x) for x in found]
            if not all(math.isfinite(x) and x >= 0 for x in found):
                raise Fault(f"margins: {key} is {found}")
            return max(found)

        self.joints = {name: greatest("encoder_zero", name) + greatest("tracking", name) for name in names}
        self.bodies = greatest("calibration") + greatest("mesh")
        self.travel = {name: math.inf for name in names}  # farthest that a coordinate may be from zero
        self.payload = both[0].get("payload") or both[1].get("payload")

    def narrow(self, limits):
        """Positions less what their joints may be off, at both ends."""
        for (name, kind), (low, high, origin) in limits.items():
            by = self.joints[name]
            if kind == "position":
                self.travel[name] = max(abs(low), abs(high))
            if kind == "position" and high - low > HELD_STILL:
                limits[name, kind] = (low + by, high - by, origin)
        return limits

    def lost(self, robot, chain, solids):
        """How far errors of the joints of a chain, the outermost first, move a body of its outermost link at most."""
        if not any(self.joints.values()):
            return 0.0
        reach, total = max(np.sqrt((v * v).sum(1)).max() + radius for v, radius in solids), 0.0
        for link in (robot.links[k] for k in chain):
            off = sum(abs(multiple) * self.joints[name] for name, multiple in link.terms.items())
            if off:
                total += off * (reach if link.kind == "revolute" else 1.0)
            reach += float(np.linalg.norm(link.position)) * (1 + 1e-12)
            if link.kind == "prismatic":
                far = sum(abs(m) * (self.travel[name] + self.joints[name]) for name, m in link.terms.items())
                reach += far + abs(link.offset)
        return total * (1 + 1e-12)

    def loaded(self, robot):
        """The robot with the payload; a torque is linear in its mass, so that none and all bound every part of it."""
        if not self.payload:
            return None
        found = copy.copy(robot)
        found.links = [copy.copy(link) for link in robot.links]
        frames = [(link, shift, turn) for link in found.links
                  for (name, shift), turn in zip(link.origins, link.turns) if name == self.payload["link"]]
        if not frames:
            raise Fault(f"margins: payload: there is no link {self.payload['link']} that a joint moves")
        link, shift, turn = frames[0]
        mass, centre = float(self.payload["mass"]), shift + turn @ np.array(self.payload["centre_of_mass"], float)
        given = self.payload.get("inertia") or {}
        tensor = np.array([[float(given.get(min(a + b, b + a)) or 0.0) for b in "xyz"] for a in "xyz"])
        tensor = turn @ tensor @ turn.T
        link.mass += mass
        link.moment = link.moment + mass * centre
        link.inertia = link.inertia + tensor - mass * skew(centre) @ skew(centre)
        return found

    def unseen(self):
        missing = [text for key, text in NAMES.items() if key not in self.given]
        return [f"errors of {', '.join(missing)}: assumed 0"] if missing else []


def stopping_limits(motion):
    """Velocities that keep every joint to the way and the time of stopping that the motion's file has; and both."""
    claimed = ((motion.get("margins") or {}).get("stopping") or {}).get("joints") or []
    if not claimed:
        return {}, ""
    way, time = max(float(x["way"]) for x in claimed), max(float(x["time_s"]) for x in claimed)
    found = {}
    for joint in motion["joints"]:
        a = float(joint["limits"]["acceleration"])
        most = min(math.sqrt(2 * a * way), a * time) * (1 + ROUNDING)
        found[joint["coordinate"], "velocity"] = (-most, most, "stopping")
    return found, f"stopping takes at most {way:.4g} rad (m) and {time:.4g} s at the limits of acceleration"
