"""Build the run folder of a crashed run."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path

from graphnav.core.run_folder import GRAPH
from graphnav.core.runner import Outcome
from graphnav.core.runner.recording.progress_file import last_call
from graphnav.core.runner.recording.summary import SUMMARY, Summary, versions
from graphnav.studies.ablation.worker import Result, Task

DIED = "its process died, twice: it takes more memory than there is, or a stage crashes it"


def died_result(task: Task, scratch: Path) -> Result:
    """Return the result of a run whose process died; ``scratch`` is the folder in which it was made."""
    call = last_call(scratch)
    return Result(task, {}, died=True, last_call=str(call) if call is not None else "")


def crashed_run_files(result: Result) -> Mapping[str, bytes]:
    """Return the files of a run that crashed its process: the graph, and a summary with that failure."""
    task = result.task
    summary = Summary(
        outcome=Outcome.FAILED,
        failure=DIED + (f"; the last call was {result.last_call}" if result.last_call else ""),
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
