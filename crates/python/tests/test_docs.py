"""The code of docs/how-to/python.md and of the examples runs."""

import ast
import inspect
import re
import runpy
import shutil

import numpy as np
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


def test_the_lines_of_the_readme_run(tmp_path, monkeypatch, recwarn):
    [block] = re.findall(r"^```python\n(.*?)^```", (ROOT / "README.md").read_text(), re.MULTILINE | re.DOTALL)
    shutil.copy(MODELS / "ur5.urdf", tmp_path / "robot.urdf")
    # The content decides the format of a log, not its name.
    shutil.copy(ROOT / "docs/ur5/log.csv", tmp_path / "log.mcap")
    monkeypatch.chdir(tmp_path)
    names = dict(zip(("q", "dq", "ddq"), np.random.default_rng(1).normal(size=(3, 5, 6))))
    exec(compile(block, "README.md", "exec"), names)
    assert names["w"].shape == (5 * 6, 36) and names["estimate"].verdict.trust != "no"


def test_the_notebook_runs(tmp_path, monkeypatch, recwarn):
    monkeypatch.chdir(tmp_path)
    names = runpy.run_path(str(ROOT / "crates/python/examples/identify_an_arm.py"))
    assert names["validation"].total < 0.1


def arguments_of(stub):
    found = stub.args
    keywords = [found.kwarg] if found.kwarg else []
    return [a.arg for a in (*found.posonlyargs, *found.args, *found.kwonlyargs, *keywords) if a.arg != "self"]


def defaults_of(stub):
    """Defaults by name, of what has one."""
    positional = [*stub.args.posonlyargs, *stub.args.args]
    behind = positional[len(positional) - len(stub.args.defaults) :]
    pairs = [*zip(behind, stub.args.defaults), *zip(stub.args.kwonlyargs, stub.args.kw_defaults)]
    return {argument.arg: ast.literal_eval(default) for argument, default in pairs if default is not None}


def test_an_editor_shows_what_help_says():
    """Docstrings in the stub, which editors show, are those of the package, on every function, method and property."""
    stubs = ast.parse((ROOT / "crates/python/python/rist/__init__.pyi").read_text()).body
    counted = 0
    for node in stubs:
        if isinstance(node, ast.FunctionDef):
            assert ast.get_docstring(node) == inspect.getdoc(getattr(rist, node.name)), node.name
            counted += 1
        elif isinstance(node, ast.ClassDef) and node.name != "Frame":
            for member in node.body:
                is_overload = isinstance(member, ast.FunctionDef) and any(getattr(d, "id", "") == "overload" for d in member.decorator_list)
                if not isinstance(member, ast.FunctionDef) or member.name.startswith("_") or is_overload:
                    continue
                said = inspect.getdoc(getattr(getattr(rist, node.name), member.name))
                assert said and ast.get_docstring(member) == said, f"{node.name}.{member.name}"
                counted += 1
    assert counted > 110


def test_every_name_has_its_stub():
    """What the stubs say is there, with these arguments and defaults, and what is there has its stub."""
    stubs = ast.parse((ROOT / "crates/python/python/rist/__init__.pyi").read_text()).body
    classes = {node.name: node for node in stubs if isinstance(node, ast.ClassDef)}
    functions = {node.name: node for node in stubs if isinstance(node, ast.FunctionDef)}
    names = {name for name in vars(rist) if not name.startswith("_")}
    # Frame is a protocol for the reader of the stubs.
    assert names == (set(classes) | set(functions)) - {"Frame"}
    for name, stub in functions.items():
        found = inspect.signature(getattr(rist, name)).parameters
        assert list(found) == arguments_of(stub), name
        defaults = {p.name: p.default for p in found.values() if p.default is not inspect.Parameter.empty}
        assert defaults == defaults_of(stub), name
    for name in names & set(classes):
        members = {m: value for m, value in vars(getattr(rist, name)).items() if not m.startswith("_")}
        methods = {node.name: node for node in classes[name].body if isinstance(node, ast.FunctionDef)}
        methods = {m: node for m, node in methods.items() if not m.startswith("_")}
        assert set(members) == set(methods), name
        for method, stub in methods.items():
            if not any(getattr(d, "id", "") == "property" for d in stub.decorator_list):
                found = list(inspect.signature(getattr(getattr(rist, name), method)).parameters)
                assert [x for x in found if x != "self"] == arguments_of(stub), f"{name}.{method}"
