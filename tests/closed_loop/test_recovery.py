"""A robot that false obstacles have shut in: without the recovery it turns on the spot, with it it drives on."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from graphnav import Recording, RecoveryState, State
from graphnav.core.runner.recording.summary import Summary

Drive = Callable[..., tuple[Summary, Recording]]

SEED, BEGIN_S, END_S = 3, 5, 13
"""The false obstacles appear before the first door, and are shown for so long that they are all around the robot."""

RINGING = f'''
"""A detector that for some seconds sees a ring of obstacles around the robot."""

from dataclasses import replace

import numpy as np

from graphnav import Flow, FlowDeviation, Mount, Plane, Stamp, hookimpl
from graphnav_plane.homography import Homography


class Detector(Homography):
    """The homography, and a ring of false obstacles 0.4 m around the robot."""

    def step(self, flow: Flow, stamp: Stamp, deviation: FlowDeviation | None = None) -> Plane:
        plane = super().step(flow, stamp, deviation)
        if not {BEGIN_S} <= stamp * 1e-6 < {END_S}:
            return plane
        away_m = Mount(1.0, 75.0, 70.0, 0.0).floor_distance_m(*plane.valid.shape)
        ring = (away_m > 0.4) & (away_m < 0.5)
        return replace(plane, obstacle=plane.obstacle | ring, valid=np.ones_like(plane.valid))


@hookimpl
def graphnav_stages():
    return [Detector]
'''


def doing(log: Recording) -> set[str]:
    return {state.doing for _, _, state in log.messages("recovery.state") if isinstance(state, RecoveryState)}


@pytest.mark.slow
def test_a_robot_that_is_shut_in_gets_on_and_arrives(drive: Drive, tmp_path: Path) -> None:
    (tmp_path / "ringing.py").write_text(RINGING)
    (tmp_path / "shut_in.yaml").write_text(
        "extends: [suite/doors, parts/navigate]\n"
        "plugins: [ringing.py]\n"
        "stages:\n"
        "  plane:\n"
        "    use: ringing.detector\n"
        "    with: {threshold_px: 0.05, mad_ratio: 3, strong_ratio: 1.6, min_cells: 4}\n"
        "    in: {flow: flow.flow, deviation: flow.deviation}\n"
    )
    graph = str(tmp_path / "shut_in.yaml")
    summary, log = drive(graph, SEED, "recovery.turns=0", "run.until_s=30")
    with log:
        states = [state for utime, _, state in log.messages("robot.state") if utime > END_S * 1_000_000]
        places = [(state.x_m, state.y_m) for state in states if isinstance(state, State)]
        assert doing(log) == {""}
    xs, ys = zip(*places, strict=True)
    assert max(xs) - min(xs) < 0.2, "it turns on the spot"
    assert max(ys) - min(ys) < 0.2
    summary, log = drive(graph, SEED, "run.until_s=60")
    with log:
        assert doing(log) == {"", "look_again"}
    assert summary.outcome == "goal"
    assert summary.scores["recovery"] == {"recoveries": 1.0}
