"""Build the run folder of a crashed run."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path

from graphnav.ablation.worker import Task
from graphnav.run_folder import GRAPH
from graphnav.runner import Outcome
from graphnav.runner.recording.run_recorded import SUMMARY
from graphnav.runner.recording.summary import Summary, versions

DIED = "its process died, twice: it takes more memory than there is, or a stage crashes it"


def crashed_run_files(task: Task) -> Mapping[str, bytes]:
    """Return the files of a run that crashed its process: the graph, and a summary with that failure."""
    summary = Summary(
        outcome=Outcome.FAILED,
        failure=DIED,
        cause=DIED,
        graph=Path(task.graph_path).stem,
        seed=task.seed,
        until_s=None,
        frames=0,
        sim_s=0.0,
        wall_s=0.0,
        stages={},
        scores={},
        notices=list(task.notices),
        tap_dropped=0,
        run_id="",
        versions=versions(),
    )
    text = json.dumps(summary.as_json(), indent=1) + "\n"
    return {GRAPH: task.graph_yaml.encode(), SUMMARY: text.encode()}
