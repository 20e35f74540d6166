"""Output of commands fits a terminal of 80 columns, and no path is broken into lines."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from graphnav.core.cli import main

COLS = 80
TOYS = Path(__file__).parent.parent / "errors" / "stages.py"


@pytest.fixture(autouse=True)
def _terminal(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("COLUMNS", str(COLS))
    monkeypatch.setenv("FORCE_COLOR", "1")  # rich then takes what is captured for a terminal
    monkeypatch.delenv("NO_COLOR", raising=False)
    monkeypatch.chdir(tmp_path)


def printed(words: str, capsys: pytest.CaptureFixture[str]) -> list[str]:
    """Return the lines that a command prints, without colours."""
    capsys.readouterr()
    assert main(words.split()) == 0
    return re.sub(r"\x1b\[[0-9;]*m", "", capsys.readouterr().out).splitlines()


@pytest.mark.parametrize(
    "words",
    ["stages", "stages plane", "stages steer.pca", "check navigate_live", "types", "types Plane", "types Status"],
)
def test_tables_fit(words: str, capsys: pytest.CaptureFixture[str]) -> None:
    lines = printed(words, capsys)
    tables = [line for line in lines if line.startswith(" ")]
    assert len(tables) > 4
    assert max(map(len, tables)) <= COLS
    assert "graphnav_lcm.odometry\n" not in "\n".join(map(str.rstrip, lines))


def test_a_run_ends_with_its_outcome_and_its_files(capsys: pytest.CaptureFixture[str]) -> None:
    lines = printed("run approach --until 0.5 --no-tap --no-pictures -o a_folder", capsys)
    assert max(map(len, lines)) <= COLS
    assert "time limit reached after 0.5 s" in lines
    assert lines[-2] == "all metrics and the times of the stages: -v, or summary.json"
    assert lines[-1].startswith("a_folder: run.lcmlog (")
    assert any(line.split()[:1] == ["drive.path_length_m"] for line in lines)
    info = printed("info a_folder", capsys)
    table = [line for line in info if re.match(r" \S", line)]
    assert max(map(len, table)) <= COLS
    assert sum("robot.truth" in line for line in table) == 1
    assert all(line.split()[1].endswith("_t") for line in table if line.startswith(" robot."))


def test_files_that_do_not_fit_beside_the_folder_are_below_it(capsys: pytest.CaptureFixture[str]) -> None:
    folder = "a_folder_of_a_name_that_is_long_enough_to_leave_little_room"
    lines = printed(f"run approach --until 0.2 --no-tap --no-pictures -o {folder}", capsys)
    assert lines[-2] == f"{folder}:"
    assert lines[-1].startswith("  run.lcmlog (")


def test_the_path_of_a_plugin_is_not_wrapped(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "a_folder_of_a_long_name" / "a_file_of_a_name_that_is_even_longer_than_that_of_its_folder.py"
    file.parent.mkdir()
    file.write_bytes(TOYS.read_bytes())
    assert any(str(file) in line for line in printed(f"stages toy.detector --plugin {file}", capsys))
