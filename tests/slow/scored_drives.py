"""Drives in processes of their own, of which the stages that keep score come back."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from multiprocessing import get_context
from pathlib import Path
from typing import Any

from graphnav_score.flow import Flow
from graphnav_score.plane import Plane

from graphnav.core.catalog import Catalog
from graphnav.core.graph import Override, load_graph
from graphnav.core.runner.recording.run_recorded import run_recorded
from graphnav.core.trust import Trust

Scores = dict[str, Any]
"""By the names of the stages: `Flow` and `Plane` themselves, of others what they have counted, by attribute."""


def score_drives(graph: str | Path, swaps: Sequence[Sequence[str]], jobs: int) -> list[Scores]:
    """Drive a graph once with each list of swaps, and return the scores in that order."""
    with ProcessPoolExecutor(jobs, mp_context=get_context("spawn")) as pool:
        return list(pool.map(partial(_drive, str(graph)), swaps))


def pooled(scores: Sequence[Plane]) -> Plane:
    """Return what all of ``scores`` counted together."""
    pooled_score = Plane()
    pooled_score.reset(0)
    for score in scores:
        pooled_score.merge(score)
    return pooled_score


def _drive(name: str, sets: Sequence[str]) -> Scores:
    graph = load_graph(name, Catalog(Trust(runs_all=True)), [*map(Override.parse, sets)])
    stages = graph.make_stages()
    with tempfile.TemporaryDirectory() as scratch:
        summary = run_recorded(graph, stages, Path(scratch))
    if summary.failure:
        raise RuntimeError(summary.failure)
    return {
        name: stage if isinstance(stage, Flow | Plane) else vars(stage)
        for name, stage in stages.items()
        if stage.role == "score"
    }
