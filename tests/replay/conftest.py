"""Recorded runs of the stages beside this file, and their replays."""

from __future__ import annotations

import textwrap
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from graphnav.core.catalog import Catalog
from graphnav.core.graph import Override, load_graph
from graphnav.core.record import LogWriter, Recording
from graphnav.core.run_folder import RunFolder
from graphnav.core.runner.recording.run_recorded import run_recorded
from graphnav.replay.comparison.result import ReplayResult
from graphnav.replay.log.log_graph import LogGraph, graph_to_replay
from graphnav.replay.replay import ReplayOptions, replay

STAGES = Path(__file__).parent / "stages.py"
LOOP = """
run: {until_s: 3, seed: 5}
stages:
  robot:  {use: again.robot, in: {command: gather.twist}}
  mean:   {use: again.mean, in: {image: robot.image}}
  gather: {use: again.gather, in: {twist: mean.twist, odometry: robot.odometry, goal: robot.goal}}
  late:   {use: again.late, in: {twist: gather.twist}}
  score:  {use: again.score, in: {twist: mean.twist}}
"""
Record = Callable[..., Path]
Again = Callable[..., ReplayResult]
Made = Callable[..., LogGraph]
Rewrite = Callable[..., Path]


def catalog() -> Catalog:
    """Return a catalog with the stages beside this file."""
    made = Catalog()
    made.add_file(STAGES)
    return made


@pytest.fixture
def record(tmp_path: Path) -> Record:
    """Return a function that runs the text of a graph with swaps and gives its log, of everything by default."""

    def run(text: str = LOOP, *sets: str, name: str = "run") -> Path:
        path = tmp_path / f"{name}.yaml"
        path.write_text(textwrap.dedent(text))
        is_said = "record:" in text or any(one.startswith("run.record=") for one in sets)
        everything = () if is_said else ("run.record=all",)
        graph = load_graph(path, catalog(), [*map(Override.parse, (*everything, *sets))])
        folder = tmp_path / name
        folder.mkdir()
        run_recorded(graph, graph.make_stages(), folder)
        return folder / RunFolder.LOG

    return run


@pytest.fixture
def made() -> Made:
    """Return a function that gives the graph of a log."""

    def load(log: Path, *sets: str, graph: Path | None = None) -> LogGraph:
        with Recording(log) as recording:
            return graph_to_replay(recording, catalog(), graph=graph, overrides=[*map(Override.parse, sets)])

    return load


@pytest.fixture
def again() -> Again:
    """Return a function that replays a log: ``sets`` and ``graph``, and the words of `ReplayOptions`."""

    def run(log: Path, *sets: str, graph: Path | None = None, out: Path | None = None, **options: Any) -> ReplayResult:
        with Recording(log) as recording:
            made = graph_to_replay(recording, catalog(), graph=graph, overrides=[*map(Override.parse, sets)])
            return replay(recording, made, ReplayOptions(**options), out=out)

    return run


@pytest.fixture
def rewrite(tmp_path: Path) -> Rewrite:
    """Return a function that writes a filtered copy of a log, as a logger would."""

    def write(log: Path, keep: Callable[[str, int], bool], name: str = "rewritten.lcmlog", offset_us: int = 0) -> Path:
        path = tmp_path / name
        with Recording(log) as recording, LogWriter(path) as writer:
            counts: dict[str, int] = {}
            for event in recording.events():
                index = counts.get(event.channel, 0)
                counts[event.channel] = index + 1
                if keep(event.channel, index):
                    writer.write(event.channel, event.utime + offset_us, event.data)
        return path

    return write
