"""The failed runs of a study: the worst of them, and where their pictures are."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from graphnav.core.errors import shown_path
from graphnav.core.run_folder import LOG
from graphnav.core.runner import Outcome
from graphnav.core.runner.recording.summary import SUMMARY
from graphnav.studies.ablation.plan import RUNS, Case, Job, Plan
from graphnav.studies.ablation.results.records import Record

FAILURES = "failures"
_WORST = (Outcome.CONTACT, Outcome.FAILED, Outcome.TIMEOUT)
"""A failure that is hard to explain by its summary comes first."""
_OF_BASELINES = 1
"""Baselines fail by design: one picture shows how."""


def failure_folder(case: Case, seed: int) -> str:
    """Return where a failure's pictures are, below the study's folder."""
    return f"{FAILURES}/{case.folder.removeprefix(f'{RUNS}/')}/{seed}"


def failed_run_text(record: Record, folder: Path) -> str:
    """Return the case, the seed and the cause of a run in which a stage failed, and the path of its log.

    A run whose process died has no log; its summary is named.
    """
    at = folder / record.folder
    file = at / LOG if (at / LOG).is_file() else at / SUMMARY
    return f"failed: {record.graph}, {record.variant}, seed {record.seed}: {record.failure}\n  {shown_path(file)}"


def is_failure(plan: Plan, record: Record) -> bool:
    """Return whether a run failed: it touched something, a stage failed, or its time was up before it arrived.

    The metrics that are outcomes tell whether it arrived. Without one, as on a map without a goal, a run whose time is
    up is not a failure.
    """
    if record.outcome == Outcome.TIMEOUT:
        return any(plan.metric(name).is_outcome and value == 0.0 for name, value in record.metrics.items())
    return record.outcome in _WORST


def worst_failures(plan: Plan, records: Iterable[Record], each: int) -> list[Job]:
    """Return up to ``each`` failures of every case: contacts, then failed stages, then timeouts, by seed.

    Runs that left nothing to see, because a stage failed before the first tick, do not count.
    """
    failed: dict[tuple[str, str], list[Record]] = {}
    for record in records:
        if is_failure(plan, record) and record.frames:
            failed.setdefault((record.graph, record.variant), []).append(record)
    chosen = []
    for case in plan.cases:
        if case.same_as:
            continue
        found = sorted(
            failed.get((case.graph, case.variant), ()), key=lambda r: (_WORST.index(Outcome(r.outcome)), r.seed)
        )
        number = min(each, _OF_BASELINES) if case.role == "baseline" else each
        chosen += [Job(case, record.seed) for record in found[:number]]
    return chosen
