"""Every broken study beside this file is refused, before anything runs, with exactly the text beside it.

The first line says the command, ``.`` for the file itself: ``# ablate . --seeds 0:5``, which is also what is meant
without such a line. To write the texts anew, and then read them::

    python tests/errors/studies/test_studies.py
"""

import contextlib
import io
from pathlib import Path

import pytest

from graphnav.cli import main

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent.parent
CASES = sorted(path.stem for path in HERE.glob("*.yaml"))
COMMAND = "# ablate "
PLUGINS = ("--plugin", "../stages.py", "--plugin", "stages.py")


def message_of(case: str) -> tuple[int, str]:
    """Return the exit status and what ``graphnav ablate`` prints to stderr, paths from the root of the sources.

    The working folder is this one.
    """
    first = Path(f"{case}.yaml").read_text(encoding="utf-8").partition("\n")[0]
    words = first.removeprefix(COMMAND) if first.startswith(COMMAND) else ". --seeds 0:5"
    said = io.StringIO()
    with contextlib.redirect_stderr(said):
        status = main(["ablate", *(f"{case}.yaml" if word == "." else word for word in words.split()), *PLUGINS])
    return status, said.getvalue().replace(f"{ROOT}/", "")


@pytest.mark.parametrize("case", CASES)
def test_refused_with_the_golden_message(case: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(HERE)
    status, said = message_of(case)
    assert said == Path(f"{case}.txt").read_text(encoding="utf-8")
    assert status == 2
    assert not Path("ablations").exists()


def test_every_text_has_its_study() -> None:
    assert sorted(path.stem for path in HERE.glob("*.txt")) == CASES


def _write_texts() -> None:
    with contextlib.chdir(HERE):
        for case in CASES:
            Path(f"{case}.txt").write_text(message_of(case)[1], encoding="utf-8")


if __name__ == "__main__":
    _write_texts()
