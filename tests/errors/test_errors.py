"""Every broken graph and every broken study in the folders here is refused with exactly the text beside it.

The folders say what is wrong. Files that the cases need are in folders below, as ``extends/extended``.
Lines ``# --set ...`` at the head of a graph are given to ``graphnav check``. The first line of a study says its
command, ``.`` for the file itself: ``# ablate . --seeds 0:5``, which is also what is meant without such a line.
To write the texts anew, and then read them::

    python tests/errors/test_errors.py
"""

import contextlib
import io
from pathlib import Path

import pytest

from graphnav.core.cli import main

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
STUDIES = HERE / "studies"
CASES = sorted(HERE.glob("*/*.yaml"))
OPTION, COMMAND = "# --set ", "# ablate "


def words_of(case: Path) -> list[str]:
    """Return the command line that refuses a case, for its folder."""
    lines = case.read_bytes().decode("utf-8", "replace").splitlines()
    if case.parent != STUDIES:
        options = [word for line in lines if line.startswith(OPTION) for word in ("--set", line.removeprefix(OPTION))]
        return ["check", case.name, "--plugin", "../stages.py", "--trust", *options]
    typed = lines[0].removeprefix(COMMAND) if lines and lines[0].startswith(COMMAND) else ". --seeds 0:5"
    words = [case.name if word == "." else word for word in typed.split()]
    return ["ablate", *words, "--plugin", "../stages.py", "--plugin", "stages.py"]


def message_of(case: Path) -> tuple[int, str]:
    """Return the exit status and what the command prints to stderr, paths from the root of the sources."""
    said = io.StringIO()
    with contextlib.chdir(case.parent), contextlib.redirect_stderr(said):
        status = main(words_of(case))
    return status, said.getvalue().replace(f"{ROOT}/", "")


@pytest.mark.parametrize("case", CASES, ids=lambda case: str(case.relative_to(HERE).with_suffix("")))
def test_refused_with_the_golden_message(case: Path) -> None:
    status, said = message_of(case)
    assert said == case.with_suffix(".txt").read_text(encoding="utf-8")
    assert status == 2
    assert not (case.parent / "ablations").exists(), "nothing ran"


def test_every_text_has_its_case() -> None:
    assert [text.with_suffix(".yaml") for text in sorted(HERE.glob("*/*.txt"))] == CASES


def test_every_case_is_in_a_folder_that_says_what_is_wrong() -> None:
    assert list(HERE.glob("*.yaml")) == []


if __name__ == "__main__":
    for each in CASES:
        each.with_suffix(".txt").write_text(message_of(each)[1], encoding="utf-8")
