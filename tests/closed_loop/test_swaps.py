"""Swaps of stages, parameters and a third-party file report what was rewired, pruned and defaulted."""

from __future__ import annotations

from pathlib import Path

import pytest

from graphnav.core.cli import main


@pytest.mark.parametrize(
    ("swap", "said"),
    [
        ("plane=plane.affine", "planar"),
        ("plane=plane.truth", "robot.truth"),
        ("flow=flow.dis", "flow.dis"),
        ("planar=planar.mean", "planar.mean"),
    ],
)
def test_a_swap_runs_and_says_what_it_did(
    tmp_path: Path, swap: str, said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["run", "corridor_ccw", "--set", swap, "--until", "1", "--no-tap", "--no-pictures"]
    assert main([*words, "-o", str(tmp_path / "out")]) == 0
    assert said in capsys.readouterr().out.partition("ticks, seed")[0]


def test_a_file_with_a_stage_is_enough(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["new-stage", "plane", "my_detector"]) == 0
    swap = ["--plugin", "my_detector.py", "--set", "plane=plane.my_detector"]
    capsys.readouterr()
    assert main(["run", "corridor_ccw", *swap, "--until", "1", "--no-tap", "-o", "out"]) == 0
    assert "plane.my_detector" in capsys.readouterr().out
    assert (tmp_path / "out" / "panels.png").stat().st_size > 0
