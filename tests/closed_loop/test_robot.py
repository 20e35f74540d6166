"""The world as a robot, in lockstep: driven at its own rates by a graph that fires with its images."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from graphnav import Odometry, Recording, State
from graphnav.core.runner.recording.summary import Summary

Drive = Callable[..., tuple[Summary, Recording]]
GRAPH = """
run: {until_s: 120, record: small}
stages:
  robot:   {use: world.robot, with: {map: maps/corridor_ccw.yaml, size: [80, 60]}, in: {command: control.twist}}
  plane:   {use: plane.truth, in: {truth: robot.truth}}
  steer:   {use: steer.pca, with: {about: zero, strength: gradient, gain: 16}, in: {plane: plane.plane}}
  control: {use: control.nonholonomic, with: {max_speed_mps: 0.3, max_turn_radps: 1.2}, in: {steering: steer.steering}}
  drive:   {use: score.navigation, in: {state: robot.state, map: robot.map}}
"""

NAVIGATION = """
run: {until_s: 120, record: small}
stages:
  robot:   {use: world.robot, with: {map: maps/corridor_ccw.yaml}, in: {command: control.twist}}
  flow:    {use: flow.lucas_kanade, in: {image: robot.image}}
  motion:  {use: odometry.motion, with: {max_extrapolation_s: 0.03}, in: {flow: flow.flow, odometry: robot.odometry}}
  planar:
    use: planar.motion
    with: {model: models/downward_160x120.lcmlog}
    in: {flow: flow.flow, motion: motion.motion}
  plane:   {use: plane.ica, in: {flow: flow.flow, planar: planar.planar}}
  steer:   {use: steer.pca, with: {about: zero, strength: gradient, gain: 16}, in: {plane: plane.plane}}
  control: {use: control.nonholonomic, with: {max_speed_mps: 0.3, max_turn_radps: 1.2}, in: {steering: steer.steering}}
  sight:   {use: score.plane, in: {plane: plane.plane, truth: robot.truth}}
"""


@pytest.fixture
def graph(tmp_path: Path) -> str:
    """Return the path of a graph in which the truth steers the robot."""
    path = tmp_path / "robot.yaml"
    path.write_text(GRAPH)
    return str(path)


@pytest.mark.parametrize("seed", [8, 10])
def test_it_is_driven_to_the_goal(drive: Drive, graph: str, seed: int) -> None:
    summary, _ = drive(graph, seed)
    assert summary.outcome == "goal", summary.failure
    assert summary.scores["drive"]["success"] == 1.0


def test_the_navigation_drives_it_by_odometry_of_another_rate(drive: Drive, tmp_path: Path) -> None:
    path = tmp_path / "navigation.yaml"
    path.write_text(NAVIGATION)
    summary, log = drive(str(path), 8)
    assert summary.outcome == "goal", summary.failure
    assert summary.scores["sight"]["balanced_accuracy_ratio"] > 0.8
    assert log.count("motion.motion") >= log.count("steer.steering") > 200


def test_its_odometry_keeps_its_stamps_in_the_log_and_drifts_little(drive: Drive, graph: str) -> None:
    _, log = drive(graph, 8, "run.until_s=8", "robot.state_hz=100")
    stamps = np.array([log.message("robot.odometry", k)[0] for k in range(log.count("robot.odometry"))])
    assert (np.diff(stamps) > 0).all()
    assert np.count_nonzero(stamps % 10_000) > 0.9 * len(stamps)
    *_, read = log.message("robot.odometry", -1)
    first, last = (log.message("robot.state", k)[2] for k in (0, -1))
    assert isinstance(read, Odometry)
    assert isinstance(first, State)
    assert isinstance(last, State)
    way_m = np.hypot(last.x_m - first.x_m, last.y_m - first.y_m)
    assert way_m > 1.0
    assert np.hypot(read.x_m, read.y_m) == pytest.approx(way_m, rel=0.05)


def test_the_same_seed_gives_the_same_log(drive: Drive, graph: str) -> None:
    logs = [drive(graph, seed, "run.until_s=3")[1].path.read_bytes() for seed in (5, 5, 6)]
    assert logs[0] == logs[1] != logs[2]
