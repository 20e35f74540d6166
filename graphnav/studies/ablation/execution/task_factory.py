"""Turn the jobs of a checked study into tasks."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from graphnav.core.graph import Graph, resolved_yaml
from graphnav.studies.ablation.plan import Case, CheckedStudy, Job
from graphnav.studies.ablation.worker import STALL_S, Task


class TaskFactory:
    """Turns the jobs of a checked study into tasks; each graph is written once."""

    def __init__(self, study: CheckedStudy, *, stall_s: float = STALL_S) -> None:
        self._stall_s = stall_s
        self._plan, self._graphs = study.plan, study.graphs
        self._texts: dict[str, str] = {}

    def task(self, job: Job) -> Task:
        """Return what a worker needs to make a run."""
        graph, text = self._graphs[job.case.folder], self._text(job.case)
        return Task(
            folder=job.folder,
            graph_yaml=text,
            graph_path=str(graph.path),
            notices=graph.notices,
            seed=job.seed,
            plugins=self._plan.plugins,
            versions=self._plan.versions,
            stall_s=self._stall_s,
        )

    def until_s(self, job: Job) -> float | None:
        """Return the time limit of a run, simulated seconds; None without one."""
        return self._graphs[job.case.folder].run.until_s

    def short_task(self, job: Job, until_s: float) -> Task:
        """Return the task of a run that is stopped after ``until_s`` simulated seconds at the latest."""
        graph = self._graphs[job.case.folder]
        run = replace(graph.run, until_s=min(until_s, graph.run.until_s or until_s))
        text = self._portable(replace(graph, run=run))
        return replace(self.task(job), graph_yaml=text, keeps_log=False)

    def _text(self, case: Case) -> str:
        """Return the YAML of a case's graph that loads from any folder."""
        if case.folder not in self._texts:
            self._texts[case.folder] = self._portable(self._graphs[case.folder])
        return self._texts[case.folder]

    def _portable(self, graph: Graph) -> str:
        plugins = dict.fromkeys((*graph.plugins, *map(Path, self._plan.plugins)))
        return resolved_yaml(replace(graph, plugins=tuple(plugins)), portable_paths=False)
