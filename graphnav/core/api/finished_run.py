"""A finished run: outcome, metrics, log, pictures."""

from __future__ import annotations

import io
from collections.abc import Mapping, Sequence
from functools import cached_property
from pathlib import Path
from types import MappingProxyType
from typing import Self

from graphnav.core.api.logs.log import Log
from graphnav.core.api.logs.open_completed import open_completed
from graphnav.core.api.notices import tell
from graphnav.core.api.result_folder import KeptFolder
from graphnav.core.api.run_html import run_html
from graphnav.core.errors import GraphnavError
from graphnav.core.graph import Graph
from graphnav.core.record import find_log
from graphnav.core.runner import Outcome
from graphnav.core.runner.recording.summary import Summary


class RunError(GraphnavError):
    """A run failed; ``run`` has its results up to there."""

    def __init__(self, run: Run) -> None:
        self.run = run
        super().__init__(run.failure)


class Run:
    """The results of a run; in a notebook, its pictures and metrics.

    A temporary folder exists as long as this object or its ``log``.
    """

    def __init__(
        self, graph: Graph, summary: Summary, folder: KeptFolder, pictures: Sequence[Path], error: GraphnavError | None
    ) -> None:
        self.graph = graph
        """The checked graph that ran, with every swap."""
        self.summary = summary
        """The content of ``summary.json``: steps and times of each stage, notices, versions."""
        self.pictures = tuple(pictures)
        """The pictures drawn into the run folder: the panels, and the robot's path on the map."""
        self.error = error
        """The exception of a failed run with its traceback, to be raised again; None if the run did not fail."""
        self._folder = folder

    @property
    def outcome(self) -> str:
        """The outcome: ``"goal"``, ``"contact"``, ``"timeout"``, ``"end"``, ``"stopped"`` or ``"failed"``."""
        return str(self.summary.outcome)

    @property
    def failure(self) -> str:
        """The cause of the failure, empty if it did not fail."""
        return self.summary.failure

    @cached_property
    def metrics(self) -> Mapping[str, float]:
        """The metrics of its stages, by ``stage.metric``; NaN if a metric is undefined."""
        scores = self.summary.scores
        return MappingProxyType({f"{stage}.{name}": value for stage in scores for name, value in scores[stage].items()})

    @property
    def folder(self) -> Path:
        """The run folder: ``run.lcmlog``, ``graph.yaml``, ``summary.json`` and the pictures."""
        return self._folder.path

    @cached_property
    def log(self) -> Log:
        """The log of the run; raises UserError or LogError if the log was removed or replaced."""
        return Log(open_completed(find_log(self.folder), tell=tell), keeps=self._folder)

    def check(self) -> Self:
        """Return the run itself; raise `RunError` if it failed."""
        if self.outcome == Outcome.FAILED:
            raise RunError(self) from self.error
        return self

    def __repr__(self) -> str:
        return f"<graphnav.Run {self.summary.graph}: {self.outcome} after {self.summary.sim_s:.1f} s, {self.folder}>"

    def __str__(self) -> str:
        from graphnav.core.machine.console import Console
        from graphnav.core.report.summary_text import print_summary

        text = io.StringIO()
        console = Console(file=text, highlight=False, soft_wrap=True, force_jupyter=False)
        print_summary(console, self.summary, self.graph.metrics)
        return "\n".join([text.getvalue().rstrip(), *([self.failure] if self.failure else [])])

    def _repr_html_(self) -> str:
        return run_html(self.summary, self.pictures, self.graph.metrics)
