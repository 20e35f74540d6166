"""Properties of all messages."""

from __future__ import annotations

import dataclasses

import graphnav_lcm
import numpy as np
import pytest

from graphnav import DeclarationError, Flow, Image, Map, Message, Truth, Twist
from graphnav.core.messages import snake_case


def flow(value: float) -> Flow:
    """Return a small flow with one vector's component set."""
    uv_px = np.zeros((3, 4, 2), np.float32)
    uv_px[1, 2, 0] = value
    return Flow(uv_px=uv_px, valid=np.ones((3, 4), np.uint8), interval_us=100000)


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_what_is_not_finite_is_named(value: float) -> None:
    assert flow(value).not_finite() == "uv_px"
    assert Twist(v_mps=0.0, omega_radps=value).not_finite() == "omega_radps"


@pytest.mark.parametrize("value", [0.0, 1.0, 3e38, -3e38])
def test_every_finite_number_is_finite(value: float) -> None:
    assert flow(value).not_finite() is None


def test_a_depth_above_the_horizon_may_be_infinite() -> None:
    grid = np.zeros((2, 2), np.uint8)
    depth_m = np.full((2, 2), np.inf, np.float32)
    truth = Truth(obstacle=grid, depth_m=depth_m, flow_px=np.zeros((2, 2, 2), np.float32), interval_us=1)
    assert truth.not_finite() is None


def test_thinning_keeps_every_nth_row_and_column_and_says_so() -> None:
    thin = flow(7.0).thin(2)
    assert thin.uv_px.shape == (2, 2, 2)
    assert thin.step_px == 2
    assert Image(pixels=np.zeros((5, 7, 3), np.uint8)).thin(3).pixels.shape == (2, 3, 3)


def test_messages_are_frozen() -> None:
    with pytest.raises(dataclasses.FrozenInstanceError):
        Twist(v_mps=0.0, omega_radps=0.0).v_mps = 1.0  # type: ignore[misc]


def test_a_message_without_an_lcm_type_is_refused() -> None:
    with pytest.raises(
        DeclarationError, match=r"message Nameless does not name its LCM type: write class Nameless\(Message"
    ):

        class Nameless(Message):
            """No type."""


def test_a_subclass_keeps_the_type() -> None:
    class Fast(Message, lcm=graphnav_lcm.twist_t):
        """A command of one's own."""

        v_mps: float

    assert Fast.lcm_class is graphnav_lcm.twist_t


@pytest.mark.parametrize(
    ("name", "snake"),
    [("PlanarModel", "planar_model"), ("Flow", "flow"), ("LucasKanade", "lucas_kanade"), ("ICAFast2", "ica_fast2")],
)
def test_ports_are_called_after_types(name: str, snake: str) -> None:
    assert snake_case(name) == snake


@pytest.mark.parametrize(
    ("body", "following"), [([], []), ([0, 0, 0], [1, 2, 0]), ([0, 2, 2, 2, 5, 5], [0, 2, 3, 1, 5, 4])]
)
def test_vertices_of_a_map_follow_each_other_around_their_bodies(body: list[int], following: list[int]) -> None:
    world = Map(
        kind=np.zeros(6, np.uint8),
        height_m=np.ones(6),
        vertices_m=np.zeros((len(body), 2)),
        body=np.array(body, np.int32),
        start=np.zeros(3),
        goal_m=np.zeros((0, 2)),
        robot_radius_m=0.2,
        shortest_m=0.0,
        footprint_m=np.zeros((0, 2)),
    )
    assert world.next_vertices().tolist() == following
