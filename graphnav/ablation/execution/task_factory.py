"""Turn the jobs of a plan into tasks; the graph of a case is loaded once."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from graphnav.ablation.plan import Case, Job, Plan
from graphnav.ablation.worker import Task
from graphnav.catalog import Catalog
from graphnav.graph import Graph, load_graph, resolved_yaml


class TaskFactory:
    """Turns the jobs of a plan into tasks."""

    def __init__(self, plan: Plan, catalog: Catalog) -> None:
        self._plan, self._catalog = plan, catalog
        self._graphs: dict[str, tuple[Graph, str]] = {}

    def task(self, job: Job) -> Task:
        """Return what a worker needs to make a run."""
        graph, text = self._graph(job.case)
        return Task(
            folder=job.folder,
            graph_yaml=text,
            graph_path=str(graph.path),
            notices=graph.notices,
            seed=job.seed,
            plugins=self._plan.plugins,
            versions=self._plan.versions,
        )

    def _graph(self, case: Case) -> tuple[Graph, str]:
        """Return a case's graph, and the text of it that loads from any folder."""
        if case.folder not in self._graphs:
            graph = load_graph(case.source, self._catalog, case.sets)
            plugins = dict.fromkeys((*graph.plugins, *map(Path, self._plan.plugins)))
            named = replace(graph, plugins=tuple(plugins))
            self._graphs[case.folder] = graph, resolved_yaml(named, portable_paths=False)
        return self._graphs[case.folder]
