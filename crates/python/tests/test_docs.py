"""The code of docs/how-to/python.md and of the examples runs."""

import re
import runpy
import shutil

import rist
from conftest import MODELS, ROOT


def test_the_page_runs(tmp_path, monkeypatch, recwarn):
    page = (ROOT / "docs/how-to/python.md").read_text()
    blocks = re.findall(r"^```python\n(.*?)^```", page, re.MULTILINE | re.DOTALL)
    assert len(blocks) > 6
    shutil.copytree(MODELS, tmp_path / "models")
    monkeypatch.chdir(tmp_path)
    names = {}
    for block in blocks:
        exec(compile(block, "docs/how-to/python.md", "exec"), names)
    assert names["changed"].changed == []


def test_the_notebook_runs(tmp_path, monkeypatch, recwarn):
    monkeypatch.chdir(tmp_path)
    names = runpy.run_path(str(ROOT / "crates/python/examples/identify_an_arm.py"))
    assert names["validation"].total < 0.1


def test_every_name_has_its_stub():
    """What the stubs say is there, and what is there has its stub."""
    text = (ROOT / "crates/python/python/rist/__init__.pyi").read_text()
    for name in (name for name in vars(rist) if not name.startswith("_")):
        thing = getattr(rist, name)
        if isinstance(thing, type):
            part = re.search(rf"^class {name}\b.*?(?=^class |^def )", text, re.MULTILINE | re.DOTALL).group(0)
            members = {m for m in vars(thing) if not m.startswith("_")}
            assert members == {m for m in re.findall(r"def (\w+)", part) if not m.startswith("_")}, name
        elif callable(thing):
            found = re.search(rf"^def {name}\((.*?)^?\) ->", text, re.MULTILINE | re.DOTALL).group(1)
            stubs = re.findall(r"(\w+):", found)
            signature = thing.__text_signature__
            assert stubs == re.findall(r"(\w+)(?=[,=)])(?!')", re.sub(r"='[^']*'|=\([^)]*\)|=[\w.]+", "", signature)), name
