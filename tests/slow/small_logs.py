"""Logs to be damaged: of runs of a few messages in lockstep and live, and of a drive."""

from __future__ import annotations

from pathlib import Path

from graphnav.core.catalog import Catalog
from graphnav.core.graph import Override, load_graph
from graphnav.core.run_folder import RunFolder
from graphnav.core.runner.recording.run_recorded import run_recorded
from graphnav.live.run import run_live

STAGES = Path(__file__).parent / "stages" / "tiny_stages.py"
GRAPH = """\
run: {{until_s: {until_s}, seed: 1, record: all}}
stages:
  eye:  {{use: tiny.camera, with: {{rate_hz: 20}}}}
  mean: {{use: tiny.mean, in: {{image: eye.image}}}}
"""


def record_tiny(folder: Path, *, is_live: bool) -> Path:
    """Run the stages of a few pixels and return the log; ``folder`` must not exist."""
    folder.mkdir()
    path = folder / "tiny.yaml"
    path.write_text(GRAPH.format(until_s=0.15 if is_live else 0.1))
    catalog = Catalog()
    catalog.add_file(STAGES)
    graph = load_graph(path, catalog)
    if is_live:
        run_live(graph, graph.make_stages(), folder, notice=lambda _: None)
    else:
        run_recorded(graph, graph.make_stages(), folder)
    return folder / RunFolder.LOG


def record_drive(folder: Path, until_s: float) -> Path:
    """Drive through the corridor in lockstep and return the log; ``folder`` must not exist."""
    folder.mkdir()
    graph = load_graph("corridor_ccw", Catalog(), [*map(Override.parse, (f"run.until_s={until_s}", "run.record=all"))])
    run_recorded(graph, graph.make_stages(), folder)
    return folder / RunFolder.LOG
