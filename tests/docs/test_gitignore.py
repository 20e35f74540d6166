"""Files that the documented commands leave in a clone are ignored by git."""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
DOCUMENTS = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").glob("*.md"))]
CACHES = [".mypy_cache", ".ruff_cache", ".pytest_cache", ".hypothesis", ".import_linter_cache", "docs/_build"]


def outputs() -> set[str]:
    """Return files and folders that commands of the documents write, as they name them."""
    text = "\n".join(document.read_text(encoding="utf-8") for document in DOCUMENTS)
    found = {"runs", "ablations", *re.findall(r"-m venv (\S+)", text)}
    for line in re.findall(r"^ *graphnav .*$", text, re.MULTILINE):
        command = line.partition("  #")[0]
        found |= set(re.findall(r"(?: -o| >) ([\w./-]+)", command))
        for name in re.findall(r"new-stage \w+ (\w+)", command):
            found |= {f"{name}.py", f"test_{name}.py"}
    return {name for name in found if not name.startswith("/")}


def test_git_ignores_what_commands_leave() -> None:
    if shutil.which("git") is None or not (ROOT / ".git").exists():
        pytest.skip("this is not a clone, or git is not installed")
    names = sorted({*outputs(), *CACHES})
    assert {".venv", ".venv-dev"} <= set(names)
    paths = [name if "." in Path(name).name[1:] else f"{name}/file" for name in names]
    ask = ["git", "check-ignore", "--no-index", "--stdin"]
    done = subprocess.run(ask, cwd=ROOT, input="\n".join(paths), capture_output=True, text=True, check=False)
    assert sorted(set(paths) - set(done.stdout.split())) == []
