"""The cells of the notebook run, and what they show is shown as a notebook does it; no Jupyter is needed."""

import ast
import json

import pytest

import rist
from conftest import ROOT

NOTEBOOK = ROOT / "crates/python/examples/ur5.ipynb"
# What a page may be, escaped for its frame, and the frame around it.
LARGEST_SHOWN = 1.3 * (2 << 20)


def run(cell, names):
    """Runs a cell; the value of its last line, where that is an expression."""
    tree = ast.parse(cell)
    last = tree.body.pop() if isinstance(tree.body[-1], ast.Expr) else None
    exec(compile(tree, "<cell>", "exec"), names)
    return last and eval(compile(ast.Expression(last.value), "<cell>", "eval"), names)


def shown(value):
    """What a notebook shows: HTML where there is some, else the repr."""
    return value._repr_html_() if hasattr(value, "_repr_html_") else repr(value)


@pytest.mark.parametrize("has_matplotlib", [True, False])
def test_the_cells_run(tmp_path, monkeypatch, recwarn, has_matplotlib):
    if has_matplotlib:
        pytest.importorskip("matplotlib", reason="matplotlib is not installed: its plots are not drawn")
        monkeypatch.setenv("MPLBACKEND", "agg")
        import matplotlib.pyplot as pyplot

        pyplot.close("all")
    else:
        monkeypatch.setattr(rist._plot, "_pyplot", lambda: None)
    monkeypatch.chdir(tmp_path)
    cells = json.loads(NOTEBOOK.read_text())["cells"]
    code = ["".join(cell["source"]) for cell in cells if cell["cell_type"] == "code"]
    assert len(code) > 8 and all(not cell.get("outputs") for cell in cells)
    names, values = {}, []
    for cell in code:
        values.append(run(cell, names))
        assert values[-1] is None or 0 < len(shown(values[-1])) < LARGEST_SHOWN, cell
    assert names["estimate"].verdict.trust == "yes" and names["motion"].proven
    for thing in (names["estimate"], names["motion"]):
        assert shown(thing).startswith("<iframe srcdoc=") and "sandbox" in shown(thing)
    assert "inverse_dynamics" in names["source"] and (tmp_path / "motion.csv").exists()
    pictures = [value for value in values if isinstance(value, rist.Picture)]
    # The four plots: axes of matplotlib, or pictures that need nothing.
    assert len(pictures) == (0 if has_matplotlib else 4)
    assert all(svg.startswith("<svg") for picture in pictures for svg in picture.charts.values())
    if has_matplotlib:
        assert len(pyplot.get_fignums()) == 4
        pyplot.close("all")
    assert not [str(w.message) for w in recwarn if issubclass(w.category, rist.TrustWarning)]
