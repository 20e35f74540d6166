"""The first contact, in drives through the simulated world."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest
from graphnav_score.navigation import Navigation
from graphnav_world.robot import Robot
from graphnav_world.world import Pymunk

from graphnav import Finished, Latest, Stamp, Twist

QUICK: dict[str, Any] = {"speed_up_s": 0.2, "size": (16, 12), "truth": False}
WORLDS = [(Pymunk, 100_000, {}), (Robot, 10_000, {"command_timeout_s": 60.0})]


def metrics_of(world: Pymunk | Robot, v_mps: float, period_us: int) -> Mapping[str, float]:
    score, command = Navigation(), Latest(Twist(v_mps=v_mps, omega_radps=0.0), 0.01)
    world.reset(1)
    score.reset(1)
    for stamp in range(0, 20_000_000, period_us):
        ends = False
        try:
            out = world.step(command, Stamp(stamp))
        except Finished as end:
            out, ends = end.outputs, True
        if out.state is not None:
            score.step(out.state, Latest(out.map, 0.0) if out.map else Latest(), Stamp(stamp))
        if ends:
            break
    return score.summary()


def a_map(folder: Path, *obstacles: str) -> Path:
    path = folder / "map.yaml"
    path.write_text("start: {at_m: [0, 0]}\nobstacles:\n" + "".join(f"  - {one}\n" for one in obstacles))
    return path


WALL = "{box: {center_m: [2, 0], size_m: [0.2, 3]}}"
ASIDE = "{circle: {center_m: [0, 3], radius_m: 0.2}, moves: {through_m: [[0, 4]], speed_mps: 0.2}}"


def towards(speed_mps: float) -> str:
    moves = f"{{through_m: [[-3, 0.05]], speed_mps: {speed_mps}}}"
    return f"{{circle: {{center_m: [3, 0.05], radius_m: 0.2}}, moves: {moves}}}"


ACROSS = (
    "{circle: {center_m: [1.5, -1], radius_m: 0.15}, crosses: {through_m: [[1.5, 1]], speed_mps: 0.5, within_s: 1.8}}"
)


@pytest.mark.parametrize(("world", "period_us", "more"), WORLDS, ids=["pymunk", "robot"])
@pytest.mark.parametrize(
    ("obstacles", "v_mps", "expected"),
    [
        ([WALL, ASIDE], 0.4, (1, 0, 0, 0)),
        ([towards(0.3), WALL], 0.0, (1, 1, 1, 0)),
        ([towards(0.4)], 0.2, (1, 1, 1, 1)),
        ([towards(0.1)], 0.4, (1, 1, 0, 1)),
        ([WALL, towards(0.0)], 0.4, (1, 0, 0, 0)),
        ([towards(0.0)], 0.4, (1, 1, 0, 1)),
        ([ACROSS], 0.4, (1, 1, 1, 1)),
        ([towards(0.4)], 0.04, (1, 1, 1, 0)),
        ([ASIDE], 0.4, (0, 0, 0, 0)),
    ],
    ids=[
        "wall",
        "stands",
        "mover faster",
        "robot faster",
        "wall first",
        "mover rests",
        "into its side",
        "creeps",
        "nothing",
    ],
)
def test_who_ran_into_whom(
    obstacles: list[str],
    v_mps: float,
    expected: tuple[int, int, int, int],
    world: type[Pymunk | Robot],
    period_us: int,
    more: dict[str, Any],
    tmp_path: Path,
) -> None:
    metrics = metrics_of(world(map=a_map(tmp_path, *obstacles), **QUICK, **more), v_mps, period_us)
    assert tuple(metrics[name] for name in ("collision", "hit_mover", "hit_by_mover", "at_fault")) == expected


def test_where_nothing_moves_it_is_left_out(tmp_path: Path) -> None:
    metrics = metrics_of(Pymunk(map=a_map(tmp_path, WALL), **QUICK), 0.4, 100_000)
    assert metrics["collision"] == 1
    assert metrics.keys().isdisjoint({"hit_mover", "hit_by_mover", "at_fault", "drove_into", "own_share"})


AWAY = "{circle: {center_m: [1, 0], radius_m: 0.2}, moves: {through_m: [[9, 0]], speed_mps: 0.1}}"
FROM_BEHIND = "{circle: {center_m: [-1, 0], radius_m: 0.2}, moves: {through_m: [[9, 0]], speed_mps: 0.4}}"


@pytest.mark.parametrize(("world", "period_us", "more"), WORLDS, ids=["pymunk", "robot"])
@pytest.mark.parametrize(
    ("obstacles", "v_mps", "fault", "own_share"),
    [
        ([towards(0.0)], 0.4, "drove into", 1.0),
        ([AWAY], 0.4, "drove into", 1.0),
        ([towards(0.4)], 0.0, "was run into", 0.0),
        ([FROM_BEHIND], 0.1, "was run into", 0.0),
        ([towards(0.4)], 0.04, "was run into", 0.04 / 0.44),
        ([towards(0.4)], 0.4, "both", 0.5),
        ([towards(0.1)], 0.4, "both", 0.8),
        ([towards(0.04)], 0.4, "drove into", 0.4 / 0.44),
        ([WALL, ASIDE], 0.4, "not a mover", None),
    ],
    ids=[
        "it stands",
        "it goes away",
        "robot stands",
        "robot drives away",
        "creeps",
        "head-on",
        "faster",
        "slow",
        "wall",
    ],
)
def test_whose_fault_a_contact_is(
    obstacles: list[str],
    v_mps: float,
    fault: str,
    own_share: float | None,
    world: type[Pymunk | Robot],
    period_us: int,
    more: dict[str, Any],
    tmp_path: Path,
) -> None:
    metrics = metrics_of(world(map=a_map(tmp_path, *obstacles), **QUICK, **more), v_mps, period_us)
    faults = {(0, 0, 0): "not a mover", (1, 1, 1): "drove into", (1, 0, 0): "was run into", (1, 1, 0): "both"}
    assert faults[int(metrics["hit_mover"]), int(metrics["at_fault"]), int(metrics["drove_into"])] == fault
    if own_share is None:
        assert "own_share" not in metrics
    else:
        assert metrics["own_share"] == pytest.approx(own_share, abs=0.01)
