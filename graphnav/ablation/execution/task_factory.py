"""Turn the jobs of a checked study into tasks."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from graphnav.ablation.plan import Case, CheckedStudy, Job
from graphnav.ablation.worker import Task
from graphnav.graph import resolved_yaml


class TaskFactory:
    """Turns the jobs of a checked study into tasks; each graph is written once."""

    def __init__(self, study: CheckedStudy) -> None:
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
        )

    def _text(self, case: Case) -> str:
        """Return the YAML of a case's graph that loads from any folder."""
        if case.folder not in self._texts:
            graph = self._graphs[case.folder]
            plugins = dict.fromkeys((*graph.plugins, *map(Path, self._plan.plugins)))
            named = replace(graph, plugins=tuple(plugins))
            self._texts[case.folder] = resolved_yaml(named, portable_paths=False)
        return self._texts[case.folder]
