"""A folder of logs of many robots in, one estimate a robot out.

The folder holds a folder a robot with its logs. Each log is read once, where a worker finds it, and becomes sums of some
kilobytes (`rist.Accumulator`), which are merged by robot and solved. A log that cannot be used is noted in the sums of its
robot and named by the estimate. The same function works on local threads, on processes, on Daft and on Ray.

python fleet.py MODEL FOLDER CUTOFF_HZ [threads|processes|daft|ray]
"""

import concurrent.futures
import os
import pathlib
import pickle
import sys

import rist

_models = {}


def model_of(path):
    """The model, derived once a process."""
    if path not in _models:
        _models[path] = rist.Model.read(path)
    return _models[path]


def sums_of(model_path, log, cutoff):
    """What a worker does: one log as sums; one that cannot be used is a note in them."""
    killed = os.environ.get("RIST_EXAMPLE_KILL")  # for the test of lost workers
    if killed and str(log).endswith("r1/day2.csv") and not os.path.exists(killed):
        pathlib.Path(killed).touch()
        os._exit(1)
    sums = rist.Accumulator(model_of(str(model_path)), cutoff=cutoff)
    try:
        sums.update(str(log))
    except rist.Error as error:
        sums.fail(str(log), str(error))
    return sums


def logs_of(folder):
    """(robot, log) of every log, in the order of their names."""
    return [(log.parent.name, str(log)) for log in sorted(pathlib.Path(folder).glob("*/*"))]


def solved(parts):
    """One estimate a robot out of (robot, sums)."""
    robots = {}
    for robot, sums in parts:
        robots[robot] = robots[robot].merge(sums) if robot in robots else sums
    return {robot: sums.solve() for robot, sums in robots.items()}


def on_threads(model_path, folder, cutoff, workers=None):
    """No engine: rist lets go of the interpreter lock."""
    logs = logs_of(folder)
    with concurrent.futures.ThreadPoolExecutor(workers) as pool:
        sums = pool.map(lambda log: sums_of(model_path, log[1], cutoff), logs)
        return solved(zip([robot for robot, _ in logs], sums))


def on_processes(model_path, folder, cutoff, workers=None, attempts=3):
    """Processes: one that is killed takes its pool along, and what was not done is done by the next."""
    left, parts = logs_of(folder), []
    for _ in range(attempts):
        with concurrent.futures.ProcessPoolExecutor(workers) as pool:
            tasks = {pool.submit(sums_of, model_path, log, cutoff): (robot, log) for robot, log in left}
            left = []
            for task, (robot, log) in tasks.items():
                try:
                    parts.append((robot, task.result()))
                except concurrent.futures.process.BrokenProcessPool:
                    left.append((robot, log))
        if not left:
            return solved(parts)
    raise RuntimeError(f"{len(left)} logs are left after {attempts} attempts, the first is {left[0][1]}")


def on_daft(model_path, folder, cutoff):
    """Daft: local by default, on Ray where `daft.set_runner_ray()` was called."""
    import daft

    robots, logs = zip(*logs_of(folder))

    @daft.func(return_dtype=daft.DataType.binary())
    def as_sums(log: str):
        return pickle.dumps(sums_of(model_path, log, cutoff))

    frame = daft.from_pydict({"robot": list(robots), "log": list(logs)})
    done = frame.with_column("sums", as_sums(daft.col("log"))).select("robot", "sums").to_pydict()
    return solved((robot, pickle.loads(sums)) for robot, sums in zip(done["robot"], done["sums"]))


def on_ray(model_path, folder, cutoff):
    """Ray Data: a task whose worker dies is done again, three times by default."""
    import ray

    def as_sums(row):
        return {"robot": row["robot"], "sums": pickle.dumps(sums_of(model_path, row["log"], cutoff))}

    rows = [{"robot": robot, "log": log} for robot, log in logs_of(folder)]
    done = ray.data.from_items(rows).map(as_sums).take_all()
    return solved((row["robot"], pickle.loads(row["sums"])) for row in done)


if __name__ == "__main__":
    model_path, folder, cutoff = sys.argv[1], sys.argv[2], float(sys.argv[3])
    engines = {"threads": on_threads, "processes": on_processes, "daft": on_daft, "ray": on_ray}
    engine = engines[sys.argv[4] if len(sys.argv) > 4 else "threads"]
    for robot, estimate in sorted(engine(model_path, folder, cutoff).items()):
        print(robot, f"{100 * estimate.total:.2f} %", estimate.verdict.trust, *estimate.remarks, sep="  ")
