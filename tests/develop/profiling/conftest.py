"""Profiles of small graphs, by a clock that counts how often it is read."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from contextlib import closing, nullcontext, suppress
from pathlib import Path

import pytest

from graphnav.core.catalog import Catalog
from graphnav.core.errors import StageError
from graphnav.core.graph import Graph, load_graph
from graphnav.core.runner import Lockstep
from graphnav.core.runner.recording.summary import Summary
from graphnav.develop.profiling.evaluate import profile_of
from graphnav.develop.profiling.profile import Profile
from graphnav.develop.profiling.step_functions import StepFunctions
from graphnav.develop.profiling.stopwatch import Stopwatch
from graphnav.develop.profiling.tick_spans import TickSpans

STAGES = Path(__file__).parents[2] / "core" / "runner" / "stages.py"
GRAPH = """\
run: {until_s: 20}
stages:
  count: {use: probe.counter}
  plus: {use: probe.plus, in: {twist: count}}
  join: {use: probe.join, in: {a: count, b: plus}}
"""
ProfileText = Callable[..., tuple[Profile, TickSpans]]


class Kept:
    """A receiver that keeps what it gets."""

    def __init__(self) -> None:
        self.events: list[tuple[str, int, bytes]] = []

    def write(self, channel: str, utime: int, data: bytes) -> None:
        self.events.append((channel, utime, data))


def summary_of(graph: Graph) -> Summary:
    return Summary("timeout", "", graph.path.stem, 0, None, 0, 0.0, 0.0, {}, {}, [], 0, "", {})


@pytest.fixture
def profile_text(tmp_path: Path) -> ProfileText:
    """Return a function that runs a graph and gives its profile; a reading of the clock takes a nanosecond."""

    def profiled(
        text: str = GRAPH,
        n_ticks: int = 120,
        *,
        functions: StepFunctions | None = None,
        may_fail: bool = False,
        n_sinks: int = 1,
    ) -> tuple[Profile, TickSpans]:
        path = tmp_path / "graph.yaml"
        path.write_text(text)
        catalog = Catalog()
        catalog.add_file(STAGES)
        graph = load_graph(path, catalog)
        clock = itertools.count().__next__
        spans = TickSpans(Stopwatch(clock), functions)
        lockstep = Lockstep(graph, graph.make_stages(), [Kept() for _ in range(n_sinks)], spans)
        with closing(lockstep.engine):
            lockstep.reset(0)
            with suppress(StageError) if may_fail else nullcontext():
                for _ in range(n_ticks):
                    lockstep.tick()
            assert lockstep.engine.ticks == spans.kinds.total()
        return profile_of(graph, spans, summary_of(graph), "wall", 0.0), spans

    return profiled
