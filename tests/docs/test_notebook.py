"""The notebook runs from its first cell to its last and shows what its text says."""

from __future__ import annotations

import hashlib
import json
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest

STUDY = 'study.table.loc["corridor_ccw"].round(3)'
GENERATOR = Path(__file__).resolve().parents[2] / "tools" / "gen_notebook.py"
NOTEBOOK = Path(__file__).resolve().parents[2] / "docs" / "notebook.ipynb"


def cells(path: Path) -> list[Mapping[str, Any]]:
    """Return the code cells of a notebook."""
    return [cell for cell in json.loads(path.read_text())["cells"] if cell["cell_type"] == "code"]


def executed(folder: Path) -> dict[str, list[Mapping[str, Any]]]:
    """Return the outputs of each cell by the cell's last line; the notebook runs in an empty folder."""
    command = [sys.executable, str(GENERATOR), "-o", str(folder / "executed.ipynb")]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=600)
    assert done.returncode == 0, done.stderr
    return {"".join(cell["source"]).splitlines()[-1]: cell["outputs"] for cell in cells(folder / "executed.ipynb")}


def test_it_ships_with_the_outputs_of_its_cells() -> None:
    kept = json.loads(NOTEBOOK.read_text())
    sources = ["".join(cell["source"]) for cell in cells(NOTEBOOK)]
    digest = hashlib.sha256(json.dumps(sources).encode()).hexdigest()
    assert kept["metadata"]["graphnav_cells"] == digest, "run python tools/gen_notebook.py"
    assert all(cell["outputs"] for cell in cells(NOTEBOOK))


def shown(outputs_of: dict[str, list[Mapping[str, Any]]], line: str) -> Mapping[str, str]:
    """Return what the cell that ends in ``line`` shows, by media type."""
    return {kind: "".join(text) for out in outputs_of[line] for kind, text in out.get("data", {}).items()}


@pytest.mark.slow
def test_it_runs_without_a_warning_and_shows_panels_metrics_tables_and_plots(tmp_path: Path) -> None:
    outputs_of = executed(tmp_path)
    kept = {"".join(cell["source"]).splitlines()[-1]: cell["outputs"] for cell in cells(NOTEBOOK)}
    assert shown(kept, STUDY) == shown(outputs_of, STUDY), "run python tools/gen_notebook.py"
    assert [out for outputs in outputs_of.values() for out in outputs if out.get("name") == "stderr"] == []
    html = shown(outputs_of, "run")["text/html"]
    assert html.count("data:image/png;base64,") == 2
    assert all(f'alt="{name}"' in html for name in ("panels", "map"))
    assert "auroc" in html
    assert "<svg" in shown(outputs_of, 'graphnav.draw("corridor_ccw")')["image/svg+xml"]
    for line in ("log", "control.tail(3)", STUDY):
        assert "<table" in shown(outputs_of, line)["text/html"], line
    plots = [line for line in outputs_of if "image/png" in shown(outputs_of, line)]
    assert len(plots) == 2
    assert "plane.affine" in shown(outputs_of, STUDY)["text/html"]
