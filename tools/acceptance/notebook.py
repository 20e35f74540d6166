"""The notebook runs from a plain installation of a clean clone, and shows what its text says."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from acceptance.drives import say
from acceptance.page_picture import draw_page

ROOT = Path(__file__).resolve().parents[2]
_PAGE_PX = (1100, 9000)


def notebook_item(_seeds: Sequence[int], _jobs: int) -> bool:
    """Install the ``notebook`` extra, execute the notebook, print what it shows and where its picture is."""
    folder = Path(tempfile.mkdtemp(prefix="graphnav notebook "))
    clone, work = folder / "clone", folder / "work"
    work.mkdir()
    subprocess.run(["git", "clone", "-q", str(ROOT), str(clone)], check=True)
    scripts = clone / ".venv" / "bin"
    begin_s = time.monotonic()
    _run([sys.executable, "-m", "venv", ".venv"], clone)
    _run([str(scripts / "python"), "-m", "pip", "install", "-q", ".[notebook]"], clone)
    say(f"     installed '.[notebook]' into a fresh environment in {time.monotonic() - begin_s:.0f} s: {folder}")
    begin_s = time.monotonic()
    convert = [str(scripts / "jupyter"), "nbconvert", "--output-dir", str(folder), "--ExecutePreprocessor.timeout=600"]
    notebook = str(clone / "docs" / "notebook.ipynb")
    _run([*convert, "--execute", "--to", "notebook", "--output", "executed.ipynb", notebook], work)
    say(f"     executed in {time.monotonic() - begin_s:.0f} s")
    _run([*convert, "--to", "html", "--output", "notebook.html", str(folder / "executed.ipynb")], work)
    if draw_page(folder / "notebook.html", folder / "notebook.png", _PAGE_PX):
        say(f"     look at {folder / 'notebook.png'}")
    return _is_right(folder / "executed.ipynb", left=[path.name for path in work.iterdir()])


def _run(command: Sequence[str], folder: Path) -> None:
    """Run a command, which has to succeed, on its own environment."""
    environment = {name: value for name, value in os.environ.items() if name not in ("VIRTUAL_ENV", "PYTHONPATH")}
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=False)
    if done.returncode:
        raise RuntimeError(f"{' '.join(command)}:\n{done.stdout}{done.stderr}")


def _is_right(executed: Path, left: Sequence[str]) -> bool:
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
    say(
        f"{'ok  ' if good else 'MISS'} {len(cells)} cells: {len(errors)} errors, {len(warnings)} warnings; "
        f"{inline} pictures of a run inline, {plots} plots, {drawings} drawn graph, {len(studies)} tables of a study; "
        f"{len(left)} files left in the working folder"
    )
    return good


def _shown(output: Mapping[str, Any], kind: str) -> str:
    return "".join(output.get("data", {}).get(kind, ""))
