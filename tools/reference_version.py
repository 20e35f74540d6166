"""Install a former version from the repository's history, to compare speeds with it in one run."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
REFERENCE = "7c52513"
"""Version 0.1.0 as it was before live runs: the reference of all speeds."""


def reference_python(commit: str = REFERENCE) -> Path:
    """Return the interpreter of an environment with that version installed, made at the first call.

    It is kept in ``build/reference-COMMIT``, together with its source. Raises CalledProcessError if the commit is not
    in the history (a shallow clone) or pip cannot install it.
    """
    folder = ROOT / "build" / f"reference-{commit}"
    python = folder / "venv" / "bin" / "python"
    done = folder / "complete"
    if done.exists():
        return python
    shutil.rmtree(folder, ignore_errors=True)
    source = folder / "source"
    source.mkdir(parents=True)
    archive = subprocess.run(["git", "-C", str(ROOT), "archive", commit], check=True, stdout=subprocess.PIPE)
    subprocess.run(["tar", "-x", "-C", str(source)], check=True, input=archive.stdout)
    subprocess.run([sys.executable, "-m", "venv", str(folder / "venv")], check=True)
    subprocess.run([str(python), "-m", "pip", "install", "-q", str(source)], check=True)
    done.touch()
    return python
