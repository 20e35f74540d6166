"""The notebook runs from a plain installation of a clean clone, and shows what its text says."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import pytest

from tests.targets import Targets

from .page_picture import draw_page

ROOT = Path(__file__).resolve().parents[2]
_PAGE_PX = (1100, 9000)


def test_notebook(targets: Targets, tmp_path: Path, tmp_path_factory: pytest.TempPathFactory) -> None:
    """Install the ``notebook`` extra, execute the notebook, print what it shows and where its picture is."""
    folder, drawn = tmp_path / "note book", tmp_path_factory.mktemp("notebook") / "notebook.png"
    clone, work = folder / "clone", folder / "work"
    work.mkdir(parents=True)
    subprocess.run(["git", "clone", "-q", str(ROOT), str(clone)], check=True)
    scripts = clone / ".venv" / "bin"
    begin_s = time.monotonic()
    _run([sys.executable, "-m", "venv", ".venv"], clone)
    _run([str(scripts / "python"), "-m", "pip", "install", "-q", ".[notebook]"], clone)
    targets.say(f"installed '.[notebook]' into a fresh environment in {time.monotonic() - begin_s:.0f} s")
    begin_s = time.monotonic()
    convert = [str(scripts / "jupyter"), "nbconvert", "--output-dir", str(folder), "--ExecutePreprocessor.timeout=600"]
    notebook = str(clone / "docs" / "notebook.ipynb")
    _run([*convert, "--execute", "--to", "notebook", "--output", "executed.ipynb", notebook], work)
    targets.say(f"executed in {time.monotonic() - begin_s:.0f} s")
    _run([*convert, "--to", "html", "--output", "notebook.html", str(folder / "executed.ipynb")], work)
    if draw_page(folder / "notebook.html", drawn, _PAGE_PX):
        targets.say(f"look at {drawn}")
    _judge(targets, folder / "executed.ipynb", left=[path.name for path in work.iterdir()])


def _run(command: Sequence[str], folder: Path) -> None:
    """Run a command, which has to succeed, on its own environment."""
    environment = {name: value for name, value in os.environ.items() if name not in ("VIRTUAL_ENV", "PYTHONPATH")}
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=False)
    if done.returncode:
        raise RuntimeError(f"{' '.join(command)}:\n{done.stdout}{done.stderr}")


def _judge(targets: Targets, executed: Path, left: Sequence[str]) -> None:
    cells = [cell for cell in json.loads(executed.read_text())["cells"] if cell["cell_type"] == "code"]
    outputs = [output for cell in cells for output in cell["outputs"]]
    errors = [output for output in outputs if output["output_type"] == "error"]
    warnings = [output for output in outputs if output.get("name") == "stderr"]
    html = [text for output in outputs if (text := _shown(output, "text/html"))]
    inline = sum(text.count("data:image/png;base64,") for text in html)
    plots = sum(bool(_shown(output, "image/png")) for output in outputs)
    drawings = sum(bool(_shown(output, "image/svg+xml")) for output in outputs)
    studies = [text for text in html if 'class="dataframe"' in text and "plane.affine" in text]
    good = not errors and not warnings and not left and inline >= 2 and plots >= 1 and drawings >= 1 and bool(studies)
    targets.check(
        f"{len(cells)} cells: {len(errors)} errors, {len(warnings)} warnings; {inline} pictures of a run inline, "
        f"{plots} plots, {drawings} drawn graph, {len(studies)} tables of a study; {len(left)} files left in the "
        "working folder",
        good=good,
    )


def _shown(output: Mapping[str, Any], kind: str) -> str:
    return "".join(output.get("data", {}).get(kind, ""))
