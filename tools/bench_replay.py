"""Benchmark a replay against the run of its log: 60 s of a drive through plane, steer and control."""

from __future__ import annotations

import tempfile
import time
from pathlib import Path

from taking_turns import load_told

from graphnav import Recording
from graphnav.core.catalog import Catalog
from graphnav.core.graph import Override, load_graph
from graphnav.core.run_folder import RunFolder
from graphnav.core.runner.recording.run_recorded import run_recorded
from graphnav.replay.log.log_graph import graph_to_replay
from graphnav.replay.replay import ReplayOptions, replay

GRAPH = "corridor_ccw"
UNTIL_S = 60
SLOW = "control.max_speed_mps=0.2"
"""The drive of the shipped graph finishes before 60 s."""
PLAY = ("flow.flow", "planar.planar")


def measure(until_s: float = UNTIL_S, play: tuple[str, ...] = PLAY) -> dict[str, float]:
    """Return the wall seconds of one run and of one replay of it, and their ratio."""
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        graph = load_graph(GRAPH, Catalog(), [*map(Override.parse, (f"run.until_s={until_s}", "run.record=all", SLOW))])
        stages = graph.make_stages()
        begin_s = time.monotonic()
        summary = run_recorded(graph, stages, folder)
        run_s = time.monotonic() - begin_s
        with Recording(folder / RunFolder.LOG) as recording:
            made = graph_to_replay(recording, Catalog())
            begin_s = time.monotonic()
            result = replay(recording, made, ReplayOptions(play))
            replay_s = time.monotonic() - begin_s
    if not result.is_equal:
        raise SystemExit(f"the replay differs: {result.first}")
    return {"driven, s": summary.sim_s, "run, s": run_s, "replay, s": replay_s, "ratio": replay_s / run_s}


if __name__ == "__main__":
    with load_told():
        print({name: round(value, 3) for name, value in measure().items()})
