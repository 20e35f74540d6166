"""Every broken graph beside this file is refused with exactly the text beside it.

Lines ``# --set ...`` at the head of a graph are given to the command. To write the texts anew, and then read them::

    python tests/errors/test_errors.py
"""

import contextlib
import io
from pathlib import Path

import pytest

from graphnav.cli import main

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
CASES = sorted(path.stem for path in HERE.glob("*.yaml"))
OPTION = "# --set "


def message_of(case: str) -> tuple[int, str]:
    """Return the exit status and what ``graphnav check`` prints to stderr, paths from the root of the sources.

    The working folder is this one.
    """
    lines = Path(f"{case}.yaml").read_bytes().decode("utf-8", "replace").splitlines()
    options = [word for line in lines if line.startswith(OPTION) for word in ("--set", line.removeprefix(OPTION))]
    said = io.StringIO()
    with contextlib.redirect_stderr(said):
        status = main(["check", f"{case}.yaml", "--plugin", "stages.py", *options])
    return status, said.getvalue().replace(f"{ROOT}/", "")


@pytest.mark.parametrize("case", CASES)
def test_refused_with_the_golden_message(case: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(HERE)
    status, said = message_of(case)
    assert said == Path(f"{case}.txt").read_text(encoding="utf-8")
    assert status == 2


def test_every_text_has_its_graph() -> None:
    assert sorted(path.stem for path in HERE.glob("*.txt")) == CASES


def _write_texts() -> None:
    with contextlib.chdir(HERE):
        for case in CASES:
            Path(f"{case}.txt").write_text(message_of(case)[1], encoding="utf-8")


if __name__ == "__main__":
    _write_texts()
