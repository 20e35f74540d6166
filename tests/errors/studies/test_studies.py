"""Every broken study beside this file is refused, before anything runs, with exactly the text beside it.

The first line says the command, ``.`` for the file itself: ``# ablate . --seeds 0:5``, which is also what is meant
without such a line. To write the texts anew, and then read them::

    python tests/errors/studies/test_studies.py
"""

import argparse
import contextlib
from pathlib import Path

import pytest

from graphnav.ablation.command_line import study_of_command
from graphnav.ablation.make_plan import make_plan
from graphnav.catalog import Catalog
from graphnav.errors import UserError

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent.parent
CASES = sorted(path.stem for path in HERE.glob("*.yaml"))
COMMAND = "# ablate "


def options_of(case: str) -> argparse.Namespace:
    """Return the options of a case, as ``graphnav ablate`` reads them."""
    first = Path(f"{case}.yaml").read_bytes().decode("utf-8", "replace").partition("\n")[0]
    words = first.removeprefix(COMMAND) if first.startswith(COMMAND) else ". --seeds 0:5"
    parser = argparse.ArgumentParser()
    parser.add_argument("names", nargs="+")
    for option, dest in (("--vary", "varies"), ("--set", "sets"), ("--figures", "figures")):
        parser.add_argument(option, dest=dest, action="append", default=[])
    parser.add_argument("--seeds")
    parser.add_argument("--one-at-a-time", action="store_true")
    return parser.parse_args([f"{case}.yaml" if word == "." else word for word in words.split()])


def message_of(case: str) -> str:
    """Return what is said about a case, paths from the root of the sources; the working folder is this one."""
    catalog = Catalog()
    for file in ("../stages.py", "stages.py"):
        catalog.add_file(Path(file))
    with pytest.raises(UserError) as caught:
        make_plan(study_of_command(**vars(options_of(case))), catalog, "graphnav ablate ...")
    return f"{caught.value}\n".replace(f"{ROOT}/", "")


@pytest.mark.parametrize("case", CASES)
def test_refused_with_the_golden_message(case: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(HERE)
    assert message_of(case) == Path(f"{case}.txt").read_text(encoding="utf-8")


def test_every_text_has_its_study() -> None:
    assert sorted(path.stem for path in HERE.glob("*.txt")) == CASES


def _write_texts() -> None:
    with contextlib.chdir(HERE):
        for case in CASES:
            Path(f"{case}.txt").write_text(message_of(case), encoding="utf-8")


if __name__ == "__main__":
    _write_texts()
