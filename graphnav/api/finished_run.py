"""A run that is over: how it ended, its metrics, its log, its pictures."""

from __future__ import annotations

import io
from collections.abc import Mapping, Sequence
from functools import cached_property
from pathlib import Path
from types import MappingProxyType
from typing import Self

from graphnav.api.logs.log import Log
from graphnav.api.result_folder import KeptFolder
from graphnav.api.run_html import run_html
from graphnav.errors import GraphnavError
from graphnav.graph import Graph
from graphnav.record import Recording, find_log
from graphnav.runner import Outcome
from graphnav.runner.recording.summary import Summary


class RunError(GraphnavError):
    """A stage failed, or something else ended a run before its time; ``run`` is what is left of it."""

    def __init__(self, run: Run) -> None:
        self.run = run
        super().__init__(run.failure)


class Run:
    """What a run left; in a notebook, its pictures and metrics.

    A temporary folder lives as long as this or its ``log`` does.
    """

    def __init__(
        self, graph: Graph, summary: Summary, folder: KeptFolder, pictures: Sequence[Path], error: GraphnavError | None
    ) -> None:
        self.graph = graph
        """The checked graph that ran, with every swap."""
        self.summary = summary
        """All that ``summary.json`` holds: steps and times of each stage, notices, versions."""
        self.pictures = tuple(pictures)
        """The pictures that were drawn, in the folder of the run: what the robot saw, and its path on the map."""
        self.error = error
        """What a failed run raised, with its traceback: ``raise run.error`` shows the line. None if it did not fail."""
        self._folder = folder

    @property
    def outcome(self) -> str:
        """How it ended: ``"goal"``, ``"contact"``, ``"timeout"``, ``"end"``, ``"stopped"`` or ``"failed"``."""
        return str(self.summary.outcome)

    @property
    def failure(self) -> str:
        """Why it failed; empty if it did not."""
        return self.summary.failure

    @cached_property
    def metrics(self) -> Mapping[str, float]:
        """What its stages say of it, by ``stage.metric``; NaN where a metric is not defined."""
        scores = self.summary.scores
        return MappingProxyType({f"{stage}.{name}": value for stage in scores for name, value in scores[stage].items()})

    @property
    def folder(self) -> Path:
        """The run folder: ``run.lcmlog``, ``graph.yaml``, ``summary.json`` and the pictures."""
        return self._folder.path

    @cached_property
    def log(self) -> Log:
        """Every message of it; raises UserError or LogError where the log was removed or replaced."""
        return Log(Recording(find_log(self.folder)), keeps=self._folder)

    def check(self) -> Self:
        """Return the run itself; raise `RunError` if it failed."""
        if self.outcome == Outcome.FAILED:
            raise RunError(self) from self.error
        return self

    def __repr__(self) -> str:
        return f"<graphnav.Run {self.summary.graph}: {self.outcome} after {self.summary.sim_s:.1f} s, {self.folder}>"

    def __str__(self) -> str:
        from rich.console import Console

        from graphnav.report.table import print_summary

        text = io.StringIO()
        console = Console(file=text, highlight=False, soft_wrap=True, force_jupyter=False)
        print_summary(console, self.summary, self.graph.metrics)
        return "\n".join([text.getvalue().rstrip(), *([self.failure] if self.failure else [])])

    def _repr_html_(self) -> str:
        return run_html(self.summary, self.pictures, self.graph.metrics)
