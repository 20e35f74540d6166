"""Replayable logs of drives: small, and a replay makes the full log of them, byte for byte."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import pytest

from graphnav import Recording
from graphnav.core.catalog import Catalog
from graphnav.core.graph import Override, load_graph
from graphnav.core.messages import About
from graphnav.core.run_folder import RunFolder
from graphnav.core.runner.recording.run_recorded import run_recorded
from graphnav.core.runner.recording.summary import Summary
from graphnav.replay.comparison.result import ReplayResult
from graphnav.replay.log.log_graph import graph_to_replay
from graphnav.replay.replay import ReplayOptions, replay

Drive = Callable[..., tuple[Summary, Recording]]
REPLAYABLE = "run.record=replayable"
ROBOT = """
run: {until_s: 2}
stages:
  robot:   {use: world.robot, with: {map: maps/pillars.yaml}, in: {command: guard.twist}}
  flow:    {use: flow.lucas_kanade, in: {image: robot.image}}
  plane:   {use: plane.affine, in: {flow: flow.flow}}
  steer:   {use: steer.pca, in: {plane: plane.plane}}
  control: {use: control.nonholonomic, in: {steering: steer.steering}}
  guard:   {use: control.guard, in: {command: control.twist, plane: plane.plane, image: robot.image}}
  sight:   {use: score.plane, in: {plane: plane.plane, truth: robot.truth}}
"""
PICTURES = """
stages:
  camera: {use: io.images, with: {path: PATH, gray: true}}
  flow:   {use: flow.lucas_kanade, in: {image: camera.image}}
  plane:  {use: plane.affine, in: {flow: flow.flow}}
  steer:  {use: steer.pca, in: {plane: plane.plane}}
"""


def events_of(path: Path) -> list[tuple[str, int, bytes]]:
    """Return everything in a log but how it describes itself."""
    with Recording(path) as recording:
        return [(one.channel, one.utime, one.data) for one in recording.events() if one.channel != About.CHANNEL]


def replayed(log: Path, *sets: str, out: Path | None = None) -> ReplayResult:
    """Return the result of a replay with swaps."""
    with Recording(log) as recording:
        made = graph_to_replay(recording, Catalog(), overrides=[*map(Override.parse, sets)])
        return replay(recording, made, ReplayOptions(), out=out)


@pytest.fixture(params=["corridor_ccw", "pillars", "robot", "pictures"])
def graph(request: pytest.FixtureRequest, tmp_path: Path) -> str:
    """Return a graph: worlds of one rate and of many, and pictures."""
    texts = {"robot": ROBOT, "pictures": PICTURES.replace("PATH", str(tmp_path / "frames"))}
    if request.param not in texts:
        return str(request.param)
    (tmp_path / "frames").mkdir()
    texture = np.random.default_rng(0).integers(0, 255, (16, 24), np.uint8)
    large = cv2.resize(texture, (192, 128), interpolation=cv2.INTER_CUBIC)
    for k in range(21):
        assert cv2.imwrite(str(tmp_path / "frames" / f"{k}.png"), large[:96, k : k + 128])
    path = tmp_path / f"{request.param}.yaml"
    path.write_text(texts[request.param])
    return str(path)


def test_the_full_log_is_made_again_of_less_than_a_fifth(graph: str, tmp_path: Path) -> None:
    logs = []
    for record in ("all", "replayable"):
        made = load_graph(graph, Catalog(), [*map(Override.parse, ("run.until_s=2", f"run.record={record}"))])
        folder = tmp_path / record
        folder.mkdir()
        run_recorded(made, made.make_stages(), folder)
        logs.append(folder / RunFolder.LOG)
    full, log = logs
    assert log.stat().st_size < 0.2 * full.stat().st_size
    out = tmp_path / "out.lcmlog"
    result = replayed(log, out=out)
    assert result.is_equal, result.first
    assert result.scores == result.recorded_scores
    assert events_of(out) == events_of(full)
    assert replayed(out).is_equal


def test_another_detector_sees_the_recorded_drive(drive: Drive, tmp_path: Path) -> None:
    full, log = (drive("corridor_ccw", 5, "run.until_s=2", *sets)[1].path for sets in ((), (REPLAYABLE,)))
    found = [replayed(path, "plane=plane.affine", out=tmp_path / f"{n}.lcmlog") for n, path in enumerate((full, log))]
    assert found[0].scores == found[1].scores
    assert found[0].scores["sight"] != found[0].recorded_scores["sight"]
    assert found[1].channels["robot.image"].is_equal
    assert not found[1].channels["guard.twist"].is_equal
    expected, made = (events_of(tmp_path / f"{n}.lcmlog") for n in (0, 1))
    assert [one for one in made if one[0] != "planar.planar"] == [one for one in expected if one[0] != "planar.planar"]


def test_a_score_is_added_that_reads_what_the_run_did_not_make(drive: Drive, tmp_path: Path) -> None:
    bare = tmp_path / "bare.yaml"
    bare.write_text("extends: corridor_ccw\nstages: {sense: null, sight: null, heading: null}\n")
    _, recording = drive(str(bare), 5, "run.until_s=2", REPLAYABLE)
    assert "robot.truth" not in recording.channels
    result = replayed(recording.path, "sight+=score.plane", "sight.in.plane=plane.plane", "sight.in.truth=robot.truth")
    assert result.channels["robot.image"].is_equal
    summary, _ = drive("corridor_ccw", 5, "run.until_s=2")
    assert result.scores["sight"] == summary.scores["sight"]
