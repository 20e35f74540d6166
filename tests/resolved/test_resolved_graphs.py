"""``graphnav check GRAPH --resolved`` prints exactly the text beside each graph here, which loads and means the same.

Lines ``# --set ...`` at the head of a graph are options. To rewrite the files, and then read them::

    python tests/resolved/test_resolved_graphs.py
"""

import contextlib
import io
from pathlib import Path

import pytest

from graphnav.core.cli import main

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
CASES = sorted(HERE.glob("*.yaml"))
OPTION = "# --set "


def resolved(graph: Path, *sets: str) -> str:
    """Return what the command prints, paths from the root of the sources."""
    said = io.StringIO()
    with contextlib.chdir(HERE), contextlib.redirect_stdout(said):
        assert main(["check", str(graph), "--resolved", "--plugin", "../errors/stages.py", *sets]) == 0
    return said.getvalue()


def text_of(case: Path) -> str:
    lines = case.read_text(encoding="utf-8").splitlines()
    sets = [word for line in lines if line.startswith(OPTION) for word in ("--set", line.removeprefix(OPTION))]
    return resolved(case, *sets).replace(f"{ROOT}/", "ROOT/")


def without_comments(text: str) -> list[str]:
    return [line.partition("#")[0].rstrip() for line in text.splitlines() if not line.startswith("#")]


@pytest.mark.parametrize("case", CASES, ids=lambda case: str(case.stem))
def test_resolves_to_the_golden_text(case: Path) -> None:
    assert text_of(case) == case.with_suffix(".txt").read_text(encoding="utf-8")


@pytest.mark.parametrize("case", CASES, ids=lambda case: str(case.stem))
def test_the_text_resolves_to_itself_in_any_folder(case: Path, tmp_path: Path) -> None:
    text = case.with_suffix(".txt").read_text(encoding="utf-8").replace("ROOT/", f"{ROOT}/")
    assert "extends" not in text
    (tmp_path / "h.yaml").write_text(text, encoding="utf-8")
    assert without_comments(resolved(tmp_path / "h.yaml")) == without_comments(text)


if __name__ == "__main__":
    for each in CASES:
        each.with_suffix(".txt").write_text(text_of(each), encoding="utf-8")
