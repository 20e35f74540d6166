"""Of several channels of one type, the pictures show the one that drives the robot."""

from collections.abc import Callable
from typing import Any

import pytest
from graphnav_view.signals import Signals

from graphnav import Flow, Image, PlanarModel, Plane, Potential, Steering, Twist
from graphnav.core.record import Recording

Record = Callable[..., Recording]


def graph(**stages: Any) -> dict[str, Any]:
    return {"about": "", "run": {"until_s": 5}, "stages": stages}


ROBOT = {"use": "world.pymunk", "in": {"command": "control.twist"}}
CONTROL = {"use": "control.nonholonomic", "in": {"steering": "steer.steering"}}


def test_the_plane_that_the_steering_uses_is_shown_though_others_come_first(record: Record) -> None:
    detectors = graph(
        robot=ROBOT,
        flow={"use": "flow.dis", "in": {"image": "robot.image"}},
        affine={"use": "plane.affine", "in": {"flow": "flow.flow"}},
        plane={"use": "plane.truth", "in": {"truth": "robot.truth"}},
        steer={"use": "steer.pca", "in": {"plane": "plane.plane"}},
        control=CONTROL,
    )
    signals = Signals(record(frames=3, graph=detectors, copies={"affine.plane": "plane.plane"}))
    assert signals.channel(Plane) == "plane.plane"
    assert signals.channel(Flow) == "flow.flow"
    assert signals.channel(Potential) == "steer.potential"


def test_without_a_command_the_first_of_the_graph_is_shown(record: Record) -> None:
    beside = graph(
        camera={"use": "io.video"},
        second={"use": "plane.ica", "in": {"flow": "flow.flow"}},
        plane={"use": "plane.affine", "in": {"flow": "flow.flow"}},
    )
    without = ("steer.steering", "steer.potential", "control.twist", "robot.map", "robot.state", "robot.image")
    copies = {"second.plane": "plane.plane", "camera.image": "robot.image"}
    signals = Signals(record(frames=3, graph=beside, without=without, copies=copies))
    assert signals.channel(Plane) == "second.plane"
    assert signals.channel(Image) == "camera.image"
    assert signals.channel(Steering) is None
    assert signals.first(Steering) is None


def test_a_flow_that_another_flow_is_measured_against_is_not_shown(record: Record) -> None:
    twins = graph(
        robot=ROBOT,
        truth={"use": "flow.truth", "in": {"truth": "robot.truth"}},
        flow={"use": "flow.dis", "in": {"image": "robot.image"}},
        plane={"use": "plane.affine", "in": {"flow": "flow"}},
        steer={"use": "steer.pca", "in": {"plane": "plane"}},
        control=CONTROL,
    )
    signals = Signals(record(frames=3, graph=twins, copies={"truth.flow": "flow.flow"}))
    assert signals.channel(Flow) == "flow.flow"


def test_a_renamed_channel_is_found(record: Record) -> None:
    renamed = graph(
        robot=ROBOT,
        plane={"use": "plane.motion", "in": {"image": "robot.image"}},
        steer={"use": "steer.pca", "in": {"plane": "plane.plane"}},
        control=CONTROL,
    ) | {"channels": {"robot.image": "CAMERA"}}
    copies = {"CAMERA": "robot.image", "second.image": "robot.image"}
    signals = Signals(record(frames=3, graph=renamed, without=("robot.image",), copies=copies))
    assert signals.channel(Image) == "CAMERA"


def test_joined_meets_by_stamp_and_says_none_where_a_channel_has_nothing(record: Record) -> None:
    signals = Signals(record(frames=4))
    stamps, flows, models = [], [], []
    for utime, (_, flow, model) in signals.joined(Image, Flow, PlanarModel):
        stamps.append(utime)
        flows.append(flow is not None)
        models.append(model)
    assert stamps == [0, 100_000, 200_000, 300_000]
    assert flows == [False, True, True, True]
    assert models == [None] * 4


def test_at_finds_exactly_the_stamp(record: Record) -> None:
    signals = Signals(record(frames=4))
    assert [t for t in range(0, 400_000, 50_000) if signals.at(Twist, t) is not None] == [100_000, 200_000, 300_000]


@pytest.mark.parametrize("graph_without", ["stages", "about"])
def test_a_graph_that_says_little_is_enough(record: Record, graph_without: str) -> None:
    little = {"stages": {"robot": {"use": "world.pymunk"}}, "about": "Little."}
    del little[graph_without]
    assert Signals(record(frames=2, graph=little)).channel(Image) == "robot.image"
