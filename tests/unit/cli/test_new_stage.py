"""``graphnav new-stage`` writes a stage that works and a test that passes, and overwrites nothing."""

import subprocess
import sys
from pathlib import Path

import pytest

from graphnav.catalog import Catalog
from graphnav.cli import main

FAMILIES = ["io", "world", "flow", "planar", "plane", "steer", "control", "score", "view", "mine"]


@pytest.fixture(autouse=True)
def _in_an_empty_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def test_in_every_family_the_written_test_passes(tmp_path: Path) -> None:
    for family in FAMILIES:
        assert main(["new-stage", family, f"my_{family}"]) == 0
        catalog = Catalog()
        catalog.add_file(Path(f"my_{family}.py"))
        assert catalog.stage(f"{family}.my_{family}").__name__ == f"My{family.capitalize()}"
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-W", "error", "-p", "no:cacheprovider"],
        cwd=tmp_path, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout
    assert f"{2 * len(FAMILIES)} passed" in done.stdout


def test_what_is_written_is_well_typed_and_formatted(tmp_path: Path) -> None:
    for family in FAMILIES:
        main(["new-stage", family, f"my_{family}"])
    for tool in (["ruff", "format", "--check", "--line-length", "120"], ["ruff", "check"]):
        done = subprocess.run(
            [sys.executable, "-m", *tool, "."], cwd=tmp_path, capture_output=True, text=True, check=False
        )
        assert done.returncode == 0, done.stdout


@pytest.mark.parametrize("existing", ["my_detector.py", "test_my_detector.py"])
def test_nothing_is_overwritten(existing: str, capsys: pytest.CaptureFixture[str]) -> None:
    Path(existing).write_text("mine")
    assert main(["new-stage", "plane", "my_detector"]) == 2
    assert capsys.readouterr().err.startswith(f"{existing} is there already\n")
    assert [(p.name, p.read_text()) for p in Path().iterdir()] == [(existing, "mine")]


def test_a_name_that_is_taken_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["new-stage", "plane", "ica"]) == 2
    assert capsys.readouterr().err == "'plane.ica' is there already\n  choose another name\n"


@pytest.mark.parametrize("name", ["My-Detector", "class", "1st", ""])
def test_a_name_that_cannot_be_one_is_refused(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["new-stage", "plane", name]) == 2
    assert capsys.readouterr().err.startswith(f"'{name}' cannot be a name\n")
