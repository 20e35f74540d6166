"""The notebook runs from its first cell to its last and shows what its text says."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest

STUDY = 'study.table.loc["corridor_ccw"].round(3)'
NOTEBOOK = Path(__file__).resolve().parents[2] / "docs" / "notebook.ipynb"

EXECUTE = """
import sys
import nbformat
from nbclient import NotebookClient

notebook = nbformat.read(sys.argv[1], as_version=4)
nbformat.validate(notebook)
NotebookClient(notebook, timeout=300, resources={"metadata": {"path": sys.argv[2]}}).execute()
nbformat.write(notebook, sys.argv[3])
"""
"""In a process of its own: Jupyter's packages warn of their own future."""


def cells(path: Path) -> list[Mapping[str, Any]]:
    """Return the code cells of a notebook."""
    return [cell for cell in json.loads(path.read_text())["cells"] if cell["cell_type"] == "code"]


@pytest.fixture(scope="module")
def executed(tmp_path_factory: pytest.TempPathFactory) -> dict[str, list[Mapping[str, Any]]]:
    """Return the outputs of each cell by the cell's last line; the notebook runs in an empty folder."""
    folder = tmp_path_factory.mktemp("notebook")
    (folder / "work").mkdir()
    command = [sys.executable, "-c", EXECUTE, str(NOTEBOOK), str(folder / "work"), str(folder / "executed.ipynb")]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=600)
    assert done.returncode == 0, done.stderr
    assert list((folder / "work").iterdir()) == []
    return {"".join(cell["source"]).splitlines()[-1]: cell["outputs"] for cell in cells(folder / "executed.ipynb")}


def test_it_is_kept_without_outputs() -> None:
    assert all(cell["outputs"] == [] and cell["execution_count"] is None for cell in cells(NOTEBOOK))


def test_no_cell_warns(executed: dict[str, list[Mapping[str, Any]]]) -> None:
    said = [out for outputs in executed.values() for out in outputs if out.get("name") == "stderr"]
    assert said == []


def shown(executed: dict[str, list[Mapping[str, Any]]], line: str) -> Mapping[str, str]:
    """Return what the cell that ends in ``line`` shows, by media type."""
    return {kind: "".join(text) for out in executed[line] for kind, text in out.get("data", {}).items()}


def test_the_run_shows_panels_and_metrics(executed: dict[str, list[Mapping[str, Any]]]) -> None:
    html = shown(executed, "run")["text/html"]
    assert html.count("data:image/png;base64,") == 2
    assert all(f'alt="{name}"' in html for name in ("panels", "map"))
    assert "auroc" in html
    assert "<svg" in shown(executed, 'graphnav.draw("corridor_ccw")')["image/svg+xml"]


def test_tables_and_plots_are_shown(executed: dict[str, list[Mapping[str, Any]]]) -> None:
    for line in ("log", "control.tail(3)", STUDY):
        assert "<table" in shown(executed, line)["text/html"], line
    plots = [line for line in executed if "image/png" in shown(executed, line)]
    assert len(plots) == 2
    assert "plane.affine" in shown(executed, STUDY)["text/html"]
