"""Swaps of stages, parameters and a third-party file report what was rewired, pruned and defaulted."""

from __future__ import annotations

import subprocess
import sysconfig
from pathlib import Path

import pytest

from graphnav.core.cli import main

GRAPHNAV = Path(sysconfig.get_path("scripts")) / "graphnav"


def graphnav(folder: Path, *words: str) -> str:
    """Run the command in ``folder`` and return what it printed."""
    done = subprocess.run([str(GRAPHNAV), *words], cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


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


def test_a_file_with_a_stage_is_enough(tmp_path: Path) -> None:
    graphnav(tmp_path, "new-stage", "plane", "my_detector")
    swap = ["--plugin", "my_detector.py", "--set", "plane=plane.my_detector"]
    printed = graphnav(tmp_path, "run", "corridor_ccw", *swap, "--until", "1", "--no-tap", "-o", "out")
    assert "plane.my_detector" in printed
    assert (tmp_path / "out" / "panels.png").stat().st_size > 0
