"""Where the guiding force points, in every steering that has one."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from graphnav_steer.balance import Balance
from graphnav_steer.forces import Forces
from graphnav_steer.mean_gradient import MeanGradient
from graphnav_steer.pca import Pca
from graphnav_steer.time_to_contact import TimeToContact

from graphnav import Flow, Goal, Latest, Planar, Plane, Steering

MakePlane = Callable[..., Plane]

STAGES: list[type[Forces]] = [Balance, MeanGradient, Pca, TimeToContact]
NONE: Latest[Any] = Latest()
every_stage = pytest.mark.parametrize("cls", STAGES)


def planar(*vectors: tuple[float, float], valid: int = 1) -> Latest[Planar]:
    """Return a planar flow of these vectors (right, down), one a column."""
    uv_px = np.tile(np.array(vectors, np.float32), (3, 1, 1))
    grid = np.full(uv_px.shape[:2], valid, np.uint8)
    return Latest(
        Planar(
            planar_uv_px=uv_px,
            planar_valid=grid,
            residual_px=np.zeros(grid.shape, np.float32),
            interval_us=100_000,
        ),
        0.0,
    )


def heard(bearing_rad: float) -> Latest[Goal]:
    return Latest(Goal(bearing_rad=bearing_rad, distance_m=3.0), 0.0)


def make(cls: type[Forces], **parameters: Any) -> Any:
    stage = cls(**parameters)
    stage.reset(seed=0)
    return stage


def free(make_plane: MakePlane, stage: Any) -> Any:
    """Return what the stage sees where no obstacle is: a plane, or a flow of which nothing is valid."""
    d = np.zeros((12, 16), np.uint8)
    flow = Flow(uv_px=np.zeros((12, 16, 2), np.float32), valid=d, interval_us=100_000, step_px=4)
    return make_plane(d) if isinstance(stage, Pca | MeanGradient) else flow


def steer(stage: Any, seen: Any, goal: Latest[Goal] = NONE, flow: Latest[Planar] = NONE) -> Steering:
    outputs = stage.step(seen, goal, flow)
    return outputs if isinstance(outputs, Steering) else outputs.steering


@every_stage
def test_beacon_is_followed_where_it_is_asked_for_and_heard(make_plane: MakePlane, cls: type[Forces]) -> None:
    for bearing_rad in (-2.0, -0.5, 0.5, 2.0):
        stage = make(cls, guiding="goal")
        assert steer(stage, free(make_plane, stage), heard(bearing_rad)).theta_rad == pytest.approx(bearing_rad)
    stage = make(cls, guiding="goal")
    assert steer(stage, free(make_plane, stage)).theta_rad == 0.0
    stage = make(cls, guiding="forward")
    assert steer(stage, free(make_plane, stage), heard(0.5)).theta_rad == 0.0


@every_stage
def test_the_beacon_is_the_default_of_all_but_the_paper_s_own(cls: type[Forces]) -> None:
    assert cls().guiding == ("forward" if cls is Pca else "goal")


@every_stage
def test_planar_flow_guides_to_where_the_robot_drives(make_plane: MakePlane, cls: type[Forces]) -> None:
    stage = make(cls, guiding="flow", flow_weight=1.0)
    seen = free(make_plane, stage)
    assert steer(stage, seen, flow=planar((0.0, 4.0), (0.0, 2.0))).theta_rad == pytest.approx(0.0)
    # In a turn to the left the floor moves to the right.
    turning = steer(stage, seen, flow=planar((2.0, 2.0), (4.0, 4.0)))
    assert turning.theta_rad == pytest.approx(math.pi / 4)
    assert np.hypot(*turning.guiding) == pytest.approx(1.0)
    assert steer(stage, seen, flow=planar((-3.0, 3.0))).theta_rad == pytest.approx(-math.pi / 4)
    halfway = make(cls, guiding="flow", flow_weight=0.5)
    assert steer(halfway, seen, flow=planar((-3.0, 3.0))).theta_rad == pytest.approx(-math.pi / 8)


@every_stage
@pytest.mark.parametrize("flow", [planar((0.0, 0.0)), planar((3.0, 1.0), valid=0)])
def test_robot_at_rest_is_guided_straight_on(make_plane: MakePlane, cls: type[Forces], flow: Latest[Planar]) -> None:
    stage = make(cls, guiding="flow")
    assert list(steer(stage, free(make_plane, stage), flow=flow).guiding) == [0.0, 1.0]


@every_stage
def test_missing_planar_flow_is_said_once_it_should_have_come(make_plane: MakePlane, cls: type[Forces]) -> None:
    stage = make(cls, guiding="flow")
    seen = free(make_plane, stage)
    assert steer(stage, seen).theta_rad == 0.0
    with pytest.raises(ValueError, match=r"--set steer\.in\.planar=planar\.planar"):
        steer(stage, seen)
