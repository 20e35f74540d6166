"""The command line takes words in any order, terminals of any encoding, and full disks."""

from __future__ import annotations

import io
import sys
from pathlib import Path

import pytest

from graphnav.core.cli import main
from graphnav.core.codec import encode
from graphnav.core.messages import Twist
from graphnav.core.record import LogWriter


@pytest.fixture
def log(tmp_path: Path) -> Path:
    """Return a log of three commands."""
    path = tmp_path / "log"
    with LogWriter(path) as writer:
        for k in range(3):
            writer.write("twist", k, encode(Twist(0.5, 0.0), k, k))
    return path


@pytest.mark.parametrize(
    "words",
    [["twist", "{log}", "-n", "1"], ["twist", "-n", "1", "{log}"], ["-n", "1", "twist", "{log}"]],
)
def test_options_may_stand_between_words(log: Path, capsys: pytest.CaptureFixture[str], words: list[str]) -> None:
    assert main(["echo", *(word.format(log=log) for word in words)]) == 0
    assert capsys.readouterr().out.count("v_mps") == 1


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["echo", "twist", "-n", "0"], "argument -n: '0' is not an integer above 0"),
        (["hz", "twist", "--for", "-1"], "argument --for: '-1' is not a number of seconds above 0"),
        (["spy", "--once", "--for", "nan"], "argument --for: 'nan' is not a number of seconds above 0"),
    ],
)
def test_nothing_is_listened_for_less_than_a_moment(
    capsys: pytest.CaptureFixture[str], words: list[str], said: str
) -> None:
    with pytest.raises(SystemExit, match="2"):
        main(words)
    assert said in capsys.readouterr().err


@pytest.mark.parametrize("words", [["hz", "--for=--"], ["check", "corridor_ccw", "--set=--"], ["run", "g", "-o--"]])
def test_two_dashes_are_not_the_value_of_an_option(words: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit, match="2"):
        main(words)
    assert ": '--' is not a value" in capsys.readouterr().err


@pytest.mark.parametrize("words", [["stages", "plane.ica"], ["draw", "corridor_ccw"], ["check", "corridor_ccw"]])
def test_a_terminal_that_lacks_letters_gets_question_marks(monkeypatch: pytest.MonkeyPatch, words: list[str]) -> None:
    terminal = io.TextIOWrapper(io.BytesIO(), encoding="ascii", newline="\n")
    monkeypatch.setattr(sys, "stdout", terminal)
    assert main(words) == 0
    terminal.flush()
    assert isinstance(terminal.buffer, io.BytesIO)
    terminal.buffer.getvalue().decode("ascii")


@pytest.mark.parametrize("words", [["schema"], ["stages"], ["check", "corridor_ccw"], ["--help"], ["run", "--help"]])
def test_a_full_disk_behind_the_terminal_is_said(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], words: list[str]
) -> None:
    with io.TextIOWrapper(io.FileIO("/dev/full", "w"), write_through=True) as full:
        monkeypatch.setattr(sys, "stdout", full)
        assert main(words) == 1
    assert capsys.readouterr().err == "stopped: No space left on device: standard output\n"


def test_a_removed_working_folder_is_said(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "gone"
    folder.mkdir()
    monkeypatch.chdir(folder)
    folder.rmdir()
    assert main(["check", "corridor_ccw"]) == 2
    assert (
        capsys.readouterr().err
        == "the working folder does not exist any more\n  change to one that does, such as: cd ~\n"
    )


@pytest.mark.parametrize("columns", ["0", "00", ""])
def test_a_terminal_without_width_is_printed_to(
    columns: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("COLUMNS", columns)
    assert main(["check", "corridor_ccw"]) == 0
    assert "corridor_ccw.yaml is fine" in capsys.readouterr().out


def test_line_breaks_in_names_make_no_lines(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["check", "a\nb"]) == 2
    assert capsys.readouterr().err.startswith("a\\nb: there is no such graph\n")


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["run", "corridor_ccw", "--unti", "1"], "unknown option --unti: did you mean '--until'?"),
        (["teach", "corridor_ccw", "--until-t", "1,2"], "unknown option --until-t: did you mean '--until-taught'?"),
        (["echo", "twist", "--fi=y"], "unknown option --fi: did you mean '--field'?"),
        (["play", "run.lcmlog", "--for", "1"], "unknown option --for: see graphnav play --help"),
        (["run", "corridor_ccw", "--zzz"], "unknown option --zzz: see graphnav run --help"),
        (["--versio"], "unknown option --versio: did you mean '--version'?"),
        (["rnu", "corridor_ccw"], "unknown command 'rnu': did you mean 'run'?"),
        (["zzz"], "unknown command 'zzz': see graphnav --help"),
    ],
)
def test_an_option_is_not_abbreviated(capsys: pytest.CaptureFixture[str], words: list[str], said: str) -> None:
    with pytest.raises(SystemExit, match="2"):
        main(words)
    assert capsys.readouterr().err.splitlines()[-1].endswith(f"error: {said}")


def test_graphnav_alone_prints_its_help(capsys: pytest.CaptureFixture[str]) -> None:
    assert main([]) == 0
    alone = capsys.readouterr().out
    with pytest.raises(SystemExit, match="0"):
        main(["--help"])
    assert alone == capsys.readouterr().out
