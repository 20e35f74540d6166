"""One record for each run, with the metrics that are relative to another run; which failures are drawn."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Protocol

from graphnav import Metric, Problem, UserError, shown_path
from graphnav.core.machine import read_json
from graphnav.core.run_folder import RunFolder
from graphnav.core.runner import Outcome
from graphnav.core.stage import FormerNames
from graphnav.studies.ablation.plan import RUNS, Case, Job, Plan


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


@dataclass(frozen=True)
class StageTime:
    """How long a stage's steps took in one run."""

    steps: int
    p50_ms: float
    p99_ms: float


@dataclass(frozen=True)
class Record:
    """The result of one run."""

    graph: str
    variant: str
    seed: int
    outcome: str
    failure: str
    cause: str
    """The failure without the time at which it happened: runs that failed for the same reason have the same one."""
    frames: int
    sim_s: float
    metrics: Mapping[str, float]
    """By ``stage.metric``; one that was not defined for the run is missing."""
    wall_s: float
    times: Mapping[str, StageTime]
    """By stage."""
    folder: str
    """Of the run, below the study's folder."""

    def counted(self, name: str, metric: Metric) -> float | None:
        """Return the value that ``stage.metric`` has in a comparison, None where it is not defined for the run.

        A failure never improves a result: a run in which a stage failed has what the metric declares of failed drives,
        and metrics that declare no value for them, which describe the part before the failure only, do not count.
        """
        if self.outcome != Outcome.FAILED or metric.relative_to:
            return self.metrics.get(name)
        stage = name.partition(".")[0]
        is_defined = name in self.metrics or not any(other.startswith(f"{stage}.") for other in self.metrics)
        return None if not is_defined or isinstance(metric.if_failed, str) else metric.if_failed


def read_records(plan: Plan, folder: Path) -> tuple[Record, ...]:
    """Read the existing runs of a plan, in the plan's order: graph, variant, seed.

    A case that shares its runs with another has a record of each under its own name. Runs that were stopped by hand
    are left out: they are not results. Metrics that are relative to the reference's runs are added.

    Raises
    ------
    UserError
        Summaries that are truncated or hold something else; all of them are named.
    """
    records, problems = [], dict[Path, Problem]()
    for case in plan.cases:
        for seed in plan.seeds_of(case):
            path = folder / case.folder / str(seed) / RunFolder.SUMMARY
            try:
                record = read_record(case, seed, path)
            except FileNotFoundError:
                continue
            except (OSError, ValueError, KeyError, TypeError, AttributeError, OverflowError):
                hint = "remove it and run the study again: it makes the missing runs"
                problems[path] = Problem(None, f"{shown_path(path)} is not a complete summary of a run", hint)
                continue
            if record.outcome != Outcome.STOPPED:
                records.append(record)
    if problems:
        raise UserError(problems.values())
    return tuple(
        replace(record, metrics={**record.metrics, **more}) if more else record
        for record, more in zip(records, relative_metrics(plan, records), strict=True)
    )


def read_record(case: Case, seed: int, path: Path) -> Record:
    """Read one run from its ``summary.json``; a metric that was not finite (null) is missing.

    Raises
    ------
    OSError
        There is none, or it cannot be read.
    ValueError, KeyError, TypeError, AttributeError, OverflowError
        It is truncated, or something else.
    """
    summary = read_json(path)
    return Record(
        graph=case.graph,
        variant=case.variant,
        seed=seed,
        outcome=str(Outcome(summary["outcome"])),
        failure=str(summary["failure"]),
        cause=str(summary.get("cause") or summary["failure"]),
        frames=int(summary["frames"]),
        sim_s=float(summary["sim_s"]),
        metrics=_metrics(summary["scores"]),
        wall_s=float(summary["wall_s"]),
        times={
            stage: StageTime(int(did["steps"]), float(did["p50_ms"]), float(did["p99_ms"]))
            for stage, did in summary["stages"].items()
        },
        folder=f"{case.folder}/{seed}",
    )


def in_plan_order(plan: Plan, records: Iterable[Record]) -> list[Record]:
    """Return records in the order of the plan, whatever order they were made or found in."""
    cases = {(case.graph, case.variant): place for place, case in enumerate(plan.cases)}
    seeds = {seed: place for place, seed in enumerate(plan.seeds)}
    return sorted(records, key=lambda record: (cases[record.graph, record.variant], seeds[record.seed]))


def are_cut_off(plan: Plan, runs: Iterable[Record]) -> bool:
    """Return whether the time limit ended all runs, of drives that can arrive, and none has arrived."""
    outcomes = [name for name, metric in plan.declared.items() if metric.is_outcome]
    made = list(runs)
    arrived = [run.metrics[name] for run in made for name in outcomes if name in run.metrics]
    return bool(arrived) and not any(arrived) and all(run.outcome == Outcome.TIMEOUT for run in made)


def _metrics(scores: Mapping[str, Mapping[str, Any]]) -> dict[str, float]:
    return {
        FormerNames.metric_now(f"{stage}.{metric}"): float(value)
        for stage, metrics in scores.items()
        for metric, value in metrics.items()
        if value is not None and math.isfinite(value)
    }


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
    file = at / RunFolder.LOG if (at / RunFolder.LOG).is_file() else at / RunFolder.SUMMARY
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
        chosen += [Job(case, record.seed) for record in found[: _limit_of(case, each)]]
    return chosen


def _limit_of(case: Case, each: int) -> int:
    return min(each, _OF_BASELINES) if case.role == "baseline" else each


def expected_failures(plan: Plan, records: Iterable[Record], each: int) -> float:
    """Return how many failures `worst_failures` will probably find when all runs are made; ``records``: the first.

    A case without runs fails as often as those of its graph do, a graph without any as all do.
    """
    failed: dict[tuple[str, ...], list[bool]] = {}
    for record in records:
        for key in ((), (record.graph,), (record.graph, record.variant)):
            failed.setdefault(key, []).append(is_failure(plan, record))
    expected = 0.0
    for case in plan.cases if failed else ():
        if not case.same_as:
            keys = ((case.graph, case.variant), (case.graph,), ())
            found = next(failed[key] for key in keys if key in failed)
            expected += min(_limit_of(case, each), plan.n_worlds(case) * sum(found) / len(found))
    return expected
