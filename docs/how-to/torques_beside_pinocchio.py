"""Compares the torques of rist with those of Pinocchio, for URDFs.

    python docs/how-to/torques_beside_pinocchio.py RIST FILE_OR_FOLDER..

RIST is the program. In a folder, all URDFs are compared. For each robot, joint torques are computed at five random states with
gravity, by `rist evaluate` and by Pinocchio's recursive Newton-Euler algorithm. A line gives the largest difference relative to the
largest torque, or the reason why one of the two refuses the file. The last line counts the robots. Exit code 1: a difference is
above 1e-9.

Mimic joints are independent in both. Rounded angles stay as they are. Needs pinocchio (PyPI: pin) and numpy.
"""

import pathlib
import subprocess
import sys
import tempfile

import numpy
import pinocchio

STATES = 5
LARGEST_DIFFERENCE = 1e-9  # the largest of 220 public robots is 7e-10; all but two are below 1e-11


def lines_of(rist, command, *arguments):
    done = subprocess.run([rist, command, *map(str, arguments)], capture_output=True, text=True)
    return done.stdout.splitlines() if done.returncode == 0 else [done.stderr.strip().splitlines()[0]]


def compared(rist, urdf, folder):
    """The largest relative difference, or a sentence."""
    try:
        model = pinocchio.buildModelFromUrdf(str(urdf))
    except Exception as error:
        return f"refused by Pinocchio: {str(error).splitlines()[0]}"
    if model.nv == 0 or any(joint.nv != 1 for joint in list(model.joints)[1:]):
        return "no joint, or a floating or planar one: not compared"
    data, random = model.createData(), numpy.random.default_rng(1)
    names = [model.names[k] for k in range(1, model.njoints)]
    rows, torques = [], []
    for _ in range(STATES):
        state = random.uniform(-1, 1, (3, model.nv))
        q = numpy.zeros(model.nq)
        for k, angle in zip(range(1, model.njoints), state[0]):
            # A continuous joint has the cosine and the sine of its angle.
            place, size = model.joints[k].idx_q, model.joints[k].nq
            q[place : place + size] = [angle] if size == 1 else [numpy.cos(angle), numpy.sin(angle)]
        torques.append(pinocchio.rnea(model, data, q, state[1], state[2]))
        rows.append(state.flatten())
    header = [f"{kind}_{name}" for kind in ["q", "dq", "ddq"] for name in names]
    table = folder / "states.csv"
    table.write_text("\n".join([",".join(header), *(",".join(map(repr, map(float, row))) for row in rows)]) + "\n")
    options = ["--quantity", "torque", "--mimic", "independent", "--angles", "as-given", "--any-size", "--quiet"]
    answer = lines_of(rist, "evaluate", urdf, table, *options)
    if len(answer) != STATES + 1:
        return f"refused by rist: {answer[0]}"
    columns = [name.split("_", 1)[1] for name in answer[0].split(",")]
    found = numpy.array([line.split(",") for line in answer[1:]], float)
    given = numpy.array(torques)[:, [names.index(name) for name in columns]]
    return numpy.abs(found - given).max() / max(numpy.abs(given).max(), 1e-300)


def main():
    rist, *given = sys.argv[1:]
    files = []
    for path in map(pathlib.Path, given):
        files += sorted(path.rglob("*.urdf")) if path.is_dir() else [path]
    equal, different, refused = 0, 0, 0
    with tempfile.TemporaryDirectory() as folder:
        for urdf in files:
            result = compared(rist, urdf, pathlib.Path(folder))
            if isinstance(result, str):
                refused += 1
                print(f"{urdf}: {result}")
            else:
                equal += result <= LARGEST_DIFFERENCE
                different += not result <= LARGEST_DIFFERENCE
                print(f"{urdf}: {result:.1e}")
    print(f"{equal} robots with equal torques, {different} with different ones, {refused} not compared")
    sys.exit(different > 0)


main()
