"""Replays of a recorded drive: without a swap nothing differs, and every swap is found."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from graphnav import Recording
from graphnav.core.catalog import Catalog
from graphnav.core.graph import Override, load_graph
from graphnav.core.run_folder import RunFolder
from graphnav.core.runner.recording.run_recorded import run_recorded
from graphnav.replay.comparison.result import ReplayResult
from graphnav.replay.log.log_graph import graph_to_replay
from graphnav.replay.replay import ReplayOptions, replay

Again = Callable[..., ReplayResult]


@pytest.fixture(scope="module")
def drive(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the log of two seconds of a drive, with everything in it."""
    folder = tmp_path_factory.mktemp("drive")
    graph = load_graph("corridor_ccw", Catalog(), [Override.parse("run.until_s=2"), Override.parse("run.record=all")])
    run_recorded(graph, graph.make_stages(), folder)
    return folder / RunFolder.LOG


@pytest.fixture
def again(drive: Path) -> Again:
    """Return a function that replays the drive with swaps."""

    def run(*sets: str, **options: Any) -> ReplayResult:
        with Recording(drive) as recording:
            return replay(
                recording,
                graph_to_replay(recording, Catalog(), overrides=[*map(Override.parse, sets)]),
                ReplayOptions(**options),
            )

    return run


def test_nothing_swapped_is_no_difference_on_every_channel(again: Again, drive: Path) -> None:
    result = again()
    assert result.is_equal
    assert result.n_ticks == 21
    with Recording(drive) as recording:
        made = {name for name in recording.channels if not name.startswith(("robot.", "graphnav."))}
        counts = {name: recording.count(name) for name in made}
        counts["guard.twist"] -= 1  # the stop that takes back the last command
    assert {name: channel.n_compared for name, channel in result.channels.items() if channel.n_compared} == counts
    assert result.scores == result.recorded_scores


def test_another_detector_differs_from_its_channel_on(again: Again) -> None:
    result = again("plane=plane.affine")
    assert {name for name, channel in result.channels.items() if channel.is_equal} >= {"flow.flow"}
    assert result.first is not None
    assert result.first[0] == "plane.plane"
    plane = result.channels["plane.plane"]
    assert 0 < plane.n_differing <= plane.n_compared == 20
    assert "score" in plane.fields
    assert result.scores["sight"] != result.recorded_scores["sight"]


def test_the_first_frame_that_a_change_touches_is_found(again: Again) -> None:
    result = again("control.max_speed_mps=0.1")
    assert result.first is not None
    assert result.first[0] == "control.twist"
    assert result.first[1].field == "v_mps"
    assert {name for name, channel in result.channels.items() if not channel.is_equal} == {
        "control.twist",
        "guard.twist",
    }


def test_the_middle_of_the_drive_is_played(again: Again) -> None:
    result = again(play=["flow", "planar.planar"])
    assert result.is_equal
    assert {"flow", "planar"}.isdisjoint(result.stepped)
