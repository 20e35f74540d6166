"""A stage knows which of its outputs are read."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import pytest

from graphnav import Recording, Stage, Twist
from graphnav.core.graph import Graph
from graphnav.core.runner.recording.summary import Summary

Load = Callable[[str], Graph]
Run = Callable[..., tuple[Summary, Recording]]
COUNTED = """
run: {until_s: 0.5}
stages:
  c: {use: probe.counter}
  f: {use: probe.frugal, in: {twist: c.twist}}
"""


class Outputs(NamedTuple):
    """Two ports."""

    near: Twist
    far: Twist


class Two(Stage):
    """Has two outputs."""

    def step(self, twist: Twist) -> Outputs:
        return Outputs(twist, twist)


def test_outside_of_a_graph_every_output_is_read() -> None:
    assert Two().is_read("near")
    assert Two().is_read("far")


def test_a_name_that_is_no_output_is_refused() -> None:
    with pytest.raises(ValueError, match="Two has no output 'twist': use near, far"):
        Two().is_read("twist")


def test_a_stage_leaves_out_what_nothing_reads(run: Run) -> None:
    _, log = run(COUNTED)
    assert log.count("f.twist") == 6
    assert log.count("f.extra") == 0


@pytest.mark.parametrize(
    ("reader", "count"),
    [
        ("p: {use: probe.plus, in: {twist: f.extra}}", 6),
        ("s: {use: probe.sampler, in: {command: f.extra}}", 7),  # a source: its commands end with a stop
    ],
)
def test_it_publishes_what_a_stage_reads(run: Run, reader: str, count: int) -> None:
    _, log = run(f"{COUNTED}  {reader}")
    assert log.count("f.extra") == count


def test_it_publishes_what_leaves_the_graph(load: Load) -> None:
    graph = load(f"{COUNTED}outputs: {{f.extra: {{channel: EXTRA, motor: false}}}}")
    stage = graph.make_stages()["f"]
    assert stage.is_read("extra")
    assert not stage.is_read("twist")


def test_it_publishes_what_is_read_elsewhere(load: Load) -> None:
    assert load(COUNTED).make_stages(also_read=["f.extra"])["f"].is_read("extra")
