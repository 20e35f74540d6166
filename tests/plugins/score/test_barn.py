"""The metric of the BARN challenge, by hand and against the challenge's own file of runs."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest
from graphnav_score.barn import WORLDS, Barn, metric_of
from graphnav_world.geometry.scene import Kind
from graphnav_world.maps.world_map import load_map

from graphnav import Latest, Map, Stamp, State

RUNS = Path(__file__).with_name("barn_dwa_runs.npz")
BARN = Path(__file__).parents[3] / "graphs/graphnav_graphs/maps/barn.yaml"
LENGTH_M = 12.43122916
"""Of the reference path of world 1."""


def world_map(number: int) -> Map:
    """Return a map of the obstacles of a world alone, with its goal."""
    draw = load_map(BARN, 0, 0.2, number).draw
    outlines = [body.outline for body in draw.bodies if body.kind == Kind.OBSTACLE]
    return Map(
        kind=np.full(len(outlines), Map.OBSTACLE, np.uint8),
        height_m=np.ones(len(outlines)),
        vertices_m=np.concatenate(outlines),
        body=np.repeat(np.arange(len(outlines), dtype=np.int32), 16),
        start=np.array(draw.start),
        goal_m=draw.goal_m,
        robot_radius_m=0.27,
        shortest_m=9.0,
        footprint_m=np.zeros((0, 2)),
    )


def metrics(
    arrival_s: float, *, stands_s: float = 0.0, contact: bool = False, world: Map | None = None
) -> Mapping[str, float]:
    """Return the metrics of a drive of 9 m straight ahead at a constant speed, a state every 0.1 s."""
    stage = Barn()
    stage.reset(seed=0)
    shown = world if world is not None else world_map(1)
    n_stands, n_drives = round(10 * stands_s), round(10 * arrival_s) + 1
    moved = np.concatenate([np.zeros(n_stands + 1), 0.1 + 8.9 * np.arange(n_drives) / (n_drives - 1)])
    for k, way_m in enumerate(moved.tolist()):
        is_last = k == len(moved) - 1
        state = State(
            x_m=-2.25,
            y_m=3.0 + way_m,
            yaw_rad=np.pi / 2,
            v_mps=1.0,
            omega_radps=0.0,
            clearance_m=0.4,
            contact=contact and is_last,
            at_goal=is_last and not contact,
            moving=np.zeros((0, 3)),
        )
        stage.step(state, Latest(shown, 0.0), Stamp(100_000 * k))
    return stage.summary()


@pytest.mark.parametrize(
    ("arrival_s", "expected"),
    [
        (5.0, 0.5),  # faster than 2 OT = 12.43 s: no more than that
        (12.4, 0.5),
        (20.0, LENGTH_M / 2 / 20),  # OT / AT
        (49.7, LENGTH_M / 2 / 49.7),
        (60.0, 0.125),  # slower than 8 OT = 49.72 s: no less than that
        (99.9, 0.125),
    ],
)
def test_the_metric_by_hand(arrival_s: float, expected: float) -> None:
    found = metrics(arrival_s, stands_s=3.0)
    assert found["success"] == 1.0
    assert found["arrival_s"] == pytest.approx(arrival_s), "from 0.1 m of motion on"
    assert found["barn_metric"] == pytest.approx(expected)


def test_what_comes_after_100_s_does_not_count() -> None:
    found = metrics(100.0, stands_s=9.0)
    assert (found["success"], found["timeout"], found["barn_metric"]) == (0.0, 1.0, 0.0)
    assert "arrival_s" not in found
    assert found["duration_s"] == pytest.approx(9.0 + 0.1 + 99.9)


def test_a_contact_is_no_success() -> None:
    found = metrics(20.0, contact=True)
    assert (found["success"], found["collision"], found["barn_metric"]) == (0.0, 1.0, 0.0)


def test_every_world_is_recognised_by_its_cylinders() -> None:
    with np.load(WORLDS) as stored:
        lengths, sums = stored["path_length_m"], stored["cells_crc32"]
    assert len(set(sums.tolist())) == len(lengths) == 300
    for number in (0, 1, 299):
        found = metrics(20.0, world=world_map(number))
        assert found["barn_metric"] == pytest.approx(metric_of(lengths[number], 20.0))


def test_another_map_is_refused() -> None:
    world = world_map(1)
    world.vertices_m[-16:] += 0.15
    with pytest.raises(ValueError, match="not a world of BARN: use a map with 'barn' and no other obstacles"):
        metrics(20.0, world=world)


def test_the_challenge_s_own_runs_have_the_metric_that_it_tells() -> None:
    with np.load(RUNS) as stored, np.load(WORLDS) as worlds:
        runs, lengths = stored["dwa_runs"].astype(float), worlds["path_length_m"]
    world, success, _, _, time_s = runs.T
    found = [ok * metric_of(lengths[int(one)], took) for one, ok, took in zip(world, success, time_s, strict=True)]
    assert len(found) == 500
    assert success.mean() == pytest.approx(0.85)
    assert round(float(np.mean(found)), 3) == 0.159
