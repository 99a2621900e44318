"""The command `rist` that the package brings along is the program, and the package says what an index asks for."""

import importlib.metadata
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import time

import pytest

import rist
from conftest import MODELS, ROOT

COMMAND = [sys.executable, "-m", "rist"]


def run(*arguments, **options):
    return subprocess.run([*COMMAND, *map(str, arguments)], cwd=ROOT, capture_output=True, **options)


def test_the_command_is_the_program(tmp_path):
    """Output, errors, exit codes and the pages that keep the command are the same, byte for byte."""
    program = os.environ.get("RIST_PROGRAM")
    if not program:
        pytest.skip("RIST_PROGRAM does not say where the program rist is; cargo xtask python says it")
    page = tmp_path / "page of mine.html"
    asked = [
        (0, ["--version"]),
        (0, ["identify", "--help"]),
        (0, ["inspect", "models/planar2r_vertical.yaml"]),
        (0, ["identify", "models/ur5.urdf", "docs/ur5/log.csv", "--json"]),
        (0, ["identify", "models/ur5.urdf", "docs/ur5/log.csv", "--report", page]),
        (1, ["identify", "models/scara.yaml", "docs/ur5/log.csv"]),
        (1, ["lint", "tests/data/none.urdf"]),
        (2, ["identify", "models/ur5.urdf"]),
        (2, ["inspect", "no/such.urdf"]),
        (2, ["inspekt"]),
        (2, []),
    ]
    codes = set()
    for _, words in asked:
        theirs = subprocess.run([program, *map(str, words)], cwd=ROOT, capture_output=True)
        page_of_theirs = page.read_bytes() if page in words else b""
        ours = run(*words)
        assert (ours.returncode, ours.stdout, ours.stderr) == (theirs.returncode, theirs.stdout, theirs.stderr), words
        assert (page.read_bytes() if page in words else b"") == page_of_theirs
        codes.add(ours.returncode)
    assert b"page of mine.html" in page.read_bytes()
    assert codes >= {0, 2}


def test_a_no_is_exit_code_1(tmp_path):
    text = (ROOT / "docs/ur5/log.csv").read_text().splitlines()
    # Velocities and torques stay; the first position column is turned round, as by a wrong sign.
    turned = [text[0]] + [",".join([t, *rest[:-1], str(-float(rest[-1]))]) for t, *rest in (x.split(",") for x in text[1:])]
    (tmp_path / "wrong.csv").write_text("\n".join(turned) + "\n")
    done = run("doctor", "models/ur5.urdf", tmp_path / "wrong.csv")
    assert done.returncode == 1, done.stdout.decode()


@pytest.mark.skipif(sys.platform == "win32", reason="signals of Unix")
def test_ctrl_c_ends_a_search_with_its_best():
    """Once: the search ends with the best it has. Twice: the program ends, as a shell expects it."""
    # The proof of a planar arm takes milliseconds, so its deadline after Ctrl-C decides nothing here.
    search = ["excite", MODELS / "planar2r_vertical.yaml", "--starts", "4000"]
    # A job in the background of a shell ignores the signal; here it is as at a terminal.
    default = lambda: signal.signal(signal.SIGINT, signal.SIG_DFL)
    once = subprocess.Popen([*COMMAND, *map(str, search)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, preexec_fn=default)
    # One start is done, so that there is a best; of starts side by side any may end first.
    assert " of 4000: det^(1/p)" in once.stderr.readline()
    once.send_signal(signal.SIGINT)
    out, err = once.communicate(timeout=120)
    assert "proven, between samples too" in out and "Traceback" not in err and once.returncode in (0, 1), err

    other = subprocess.Popen([*COMMAND, "identify", "models/ur5.urdf", "-"], cwd=ROOT, stdin=subprocess.PIPE, stderr=subprocess.PIPE, preexec_fn=default)
    time.sleep(1.0)
    if other.poll() is None:
        other.send_signal(signal.SIGINT)
        other.communicate(timeout=60)
        assert other.returncode == -signal.SIGINT


@pytest.mark.skipif(sys.platform == "win32", reason="pipes of Unix")
def test_a_reader_may_go_away():
    head = subprocess.run(f"'{sys.executable}' -m rist inspect models/panda.yaml | head -n 1", shell=True, cwd=ROOT, capture_output=True)
    assert head.returncode == 0 and head.stdout and not head.stderr


def test_the_command_is_installed():
    commands = importlib.metadata.entry_points(group="console_scripts", name="rist")
    assert [command.value for command in commands] == ["rist._program:main"]
    found = importlib.metadata.metadata("rist-dynamics")
    assert found["Version"] == rist.__version__ and "rist developers" in str(found["Author"])
    assert len(found.get_all("Classifier")) > 10 and "URDF" in found["Keywords"]
    installed = shutil.which("rist", path=str(pathlib.Path(sys.executable).parent))
    assert installed, "the environment has the command"
    said = subprocess.run([installed, "--version"], capture_output=True, text=True)
    assert said.stdout == f"rist {rist.__version__}\n" and said.returncode == 0


def test_the_example_comes_along(tmp_path):
    paths = rist.example(tmp_path / "ur5")
    theirs = [MODELS / "ur5.urdf", ROOT / "docs/ur5/log.csv", ROOT / "docs/ur5/other.csv"]
    assert [path.read_bytes() for path in paths] == [path.read_bytes() for path in theirs]
    assert (tmp_path / "ur5/poses.csv").read_bytes() == (ROOT / "docs/ur5/poses.csv").read_bytes()
    assert rist.example(tmp_path / "ur5") == paths
    paths[1].write_text("mine")
    with pytest.raises(rist.Error, match="log.csv: another file of this name, which is kept"):
        rist.example(tmp_path / "ur5")
    assert paths[1].read_text() == "mine"


def test_an_address_is_filled_in(tmp_path):
    """What the workflow does before it builds: no link of the page of the index is relative, and the addresses are there."""
    tomllib = pytest.importorskip("tomllib", reason="tomllib is of Python 3.11")
    for name in ("pyproject.toml", "crates/python/README.md"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / name, tmp_path / name)
    script = ROOT / "crates/python/with_address.py"
    subprocess.run([sys.executable, script, "https://example.org/a/rist.git", tmp_path], check=True)
    page = (tmp_path / "crates/python/README.md").read_text()
    targets = re.findall(r"\]\(([^)]*)\)", page)
    assert len(targets) > 3 and all(target.startswith("https://example.org/a/rist/") for target in targets), targets
    files = re.findall(r"\]\(([^)]*)\)", (ROOT / "crates/python/README.md").read_text())
    assert all((ROOT / "crates/python" / name).exists() for name in files), files
    assert "https://example.org/a/rist/raw/HEAD/docs/ur5/torque.svg" in targets
    project = tomllib.loads((tmp_path / "pyproject.toml").read_text())["project"]
    assert project["urls"]["Source"] == "https://example.org/a/rist" and project["name"] == "rist-dynamics"
    assert (ROOT / project["readme"]).exists() and project["scripts"] == {"rist": "rist._program:main"}


def test_the_workflow_calls_what_is_here():
    yaml = pytest.importorskip("yaml", reason="PyYAML is not installed: the workflow is not read")
    workflow = yaml.safe_load((ROOT / ".github/workflows/build.yml").read_text())
    called = [step["run"] for job in workflow["jobs"].values() for step in job["steps"] if step.get("run", "").startswith(".ci/")]
    assert [words.split()[0] for words in called] == [".ci/run", ".ci/wheel", ".ci/program"]
    for words in called:
        assert os.access(ROOT / words.split()[0], os.X_OK), words
    systems = {entry["os"].split("-")[0] for job in ("wheel", "program") for entry in workflow["jobs"][job]["strategy"]["matrix"]["include"]}
    assert systems == {"ubuntu", "macos", "windows"}
    # YAML takes `on` for a truth.
    assert {"push", "pull_request"} <= set(workflow[True])
