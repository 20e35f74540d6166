"""Cases of a live graph share their runs only where what comes in, what leaves and when stages fire is the same."""

from collections.abc import Callable

import pytest

from graphnav.ablation.checked_case import Checked
from graphnav.ablation.expand import Variant
from graphnav.graph import Graph

LIVE = """\
inputs: {camera.image: {channel: CAMERA, type: graphnav_lcm.image_t}}
stages:
  flow: {use: toy.matcher, in: {image: camera.image}, deadline_ms: 20}
  plane: {use: toy.detector, in: {flow: flow.flow}, every_ms: 50}
outputs: {plane.plane: {channel: PLANE}}
queues: {plane.flow: {keep: 4}}
"""
VARIANT = Variant("base", "base", "", {}, is_base=True)


def identity(graph: Graph) -> object:
    return Checked("live", VARIANT, (), graph).identity


def test_the_same_graph_is_the_same_case(load: Callable[..., Graph]) -> None:
    assert identity(load(LIVE)) == identity(load(LIVE))


@pytest.mark.parametrize(
    ("said", "other"),
    [("CAMERA", "FRONT"), ("PLANE", "FLOOR"), ("keep: 4", "keep: all"), ("20", "30"), ("50", "60")],
)
def test_what_changes_a_live_run_makes_another_case(load: Callable[..., Graph], said: str, other: str) -> None:
    assert identity(load(LIVE.replace(said, other))) != identity(load(LIVE))
