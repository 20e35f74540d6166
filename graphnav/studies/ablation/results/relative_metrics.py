"""Metrics that compare a run with the reference's run in the same world."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Protocol

from graphnav.core.runner import Outcome
from graphnav.core.stage import Metric
from graphnav.studies.ablation.plan import Plan


class Run(Protocol):
    """The part of a record that is read here."""

    @property
    def graph(self) -> str:
        """The graph, as tables call it."""

    @property
    def variant(self) -> str:
        """The variant."""

    @property
    def seed(self) -> int:
        """The world."""

    @property
    def outcome(self) -> str:
        """How it ended."""

    @property
    def metrics(self) -> Mapping[str, float]:
        """By ``stage.metric``."""


def relative_metrics(plan: Plan, runs: Sequence[Run]) -> list[Mapping[str, float]]:
    """Return, for each run, the metrics that are declared as relative to the reference's run in the same world.

    Without a reference no run has any. A world in which the reference has no run, or did not arrive so that its run
    lacks the metric, has none for any variant.
    """
    relative = {name: metric for name, metric in plan.declared.items() if metric.relative_to}
    references = {(run.graph, run.seed): run for run in runs if plan.reference and run.variant == plan.reference}
    return [
        dict(_values(plan, run, reference, relative)) if (reference := references.get((run.graph, run.seed))) else {}
        for run in runs
    ]


def _values(plan: Plan, run: Run, reference: Run, relative: Mapping[str, Metric]) -> Iterator[tuple[str, float]]:
    for name, metric in relative.items():
        stage = name.partition(".")[0]
        other = f"{stage}.{metric.relative_to}"
        best = reference.metrics.get(other) if _arrived(plan, reference, stage) else None
        if best is None or best <= 0:
            continue
        if _arrived(plan, run, stage) and (own := run.metrics.get(other)) is not None:
            yield name, best / max(own, best)
        elif not isinstance(metric.if_failed, str):
            yield name, metric.if_failed


def _arrived(plan: Plan, run: Run, stage: str) -> bool:
    """Return whether no stage failed and every outcome that the scoring stage declares is reported and not 0."""
    outcomes = (name for name, metric in plan.declared.items() if metric.is_outcome and name.startswith(f"{stage}."))
    return run.outcome != Outcome.FAILED and all(run.metrics.get(name, 0.0) != 0.0 for name in outcomes)
