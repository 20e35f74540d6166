"""The same seed gives the same log; a swap elsewhere leaves the world alone."""

from __future__ import annotations

import subprocess
from collections.abc import Callable
from pathlib import Path

import numpy as np

from graphnav import Image, Map, Recording
from graphnav.core.runner.recording.summary import Summary
from tests.forked_commands import forked_graphnav

Drive = Callable[..., tuple[Summary, Recording]]
SHORT = "run.until_s=2"


def test_the_same_seed_gives_the_same_log_and_another_does_not(drive: Drive) -> None:
    logs = [drive("corridor_ccw", seed, SHORT)[1].path.read_bytes() for seed in (5, 5, 6)]
    assert logs[0] == logs[1] != logs[2]


def test_two_processes_at_once_write_the_same_log(tmp_path: Path) -> None:
    words = ["run", "corridor_ccw", "--seed", "5", "--until", "2", "--no-tap", "--no-pictures"]
    both = [
        subprocess.Popen([str(forked_graphnav()), *words, "-o", str(tmp_path / name)], stdout=subprocess.DEVNULL)
        for name in ("a", "b")
    ]
    assert [process.wait() for process in both] == [0, 0]
    assert (tmp_path / "a" / "run.lcmlog").read_bytes() == (tmp_path / "b" / "run.lcmlog").read_bytes()


def test_swapping_the_detector_changes_neither_the_map_nor_the_textures(drive: Drive) -> None:
    firsts = []
    for swap in ("plane=plane.ica", "plane=plane.truth"):
        _, log = drive("corridor_ccw", 5, swap, SHORT)
        _, _, world = log.message("robot.map", 0)
        _, _, image = log.message("robot.image", 0)
        assert isinstance(world, Map)
        assert isinstance(image, Image)
        firsts.append((world.vertices_m, image.pixels))
    assert np.array_equal(firsts[0][0], firsts[1][0])
    assert np.array_equal(firsts[0][1], firsts[1][1])


def test_the_drive_is_the_same_whether_it_is_scored_or_not(drive: Drive, tmp_path: Path) -> None:
    unscored = tmp_path / "unscored.yaml"
    unscored.write_text("extends: corridor_ccw\nstages: {sense: null, sight: null, heading: null}\n")
    _, full = drive("corridor_ccw", 5, SHORT)
    for sets in ([], ["robot.truth=true"]):
        _, bare = drive(str(unscored), 5, *sets, SHORT)
        assert ("robot.truth" in bare.channels) is bool(sets)
        common = {*full.channels} - {"graphnav.about", "robot.truth"}
        assert common == {*bare.channels} - {"graphnav.about", "robot.truth"}
        ours, theirs = ([(e.channel, e.data) for e in log.events() if e.channel in common] for log in (bare, full))
        assert ours == theirs


def test_a_resolved_graph_gives_the_same_run_again(drive: Drive) -> None:
    _, log = drive("corridor_ccw", 5, "plane=plane.affine", SHORT)
    _, again = drive(str(log.path.with_name("graph.yaml")), 5)
    ours, theirs = list(log.events())[1:], list(again.events())[1:]
    assert ours == theirs
