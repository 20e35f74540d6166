"""Make the trials of a tuning, as the tree-structured Parzen estimator of Optuna proposes them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from graphnav.core.runner import Outcome
from graphnav.studies.ablation.execution import StudyFolder, TaskFactory, Workers, execute, pending_jobs
from graphnav.studies.ablation.plan import CheckedStudy, Job, Plan
from graphnav.studies.ablation.results import Record, read_records, values_of
from graphnav.studies.ablation.study import MetricExpression
from graphnav.studies.ablation.worker import Task
from graphnav.studies.tuning.rivals import Rival
from graphnav.studies.tuning.search_range import SearchRange
from graphnav.studies.tuning.trial import DEFAULT, Trial, in_order, in_ranks, ranks
from graphnav.studies.tuning.tuning import Tuning, label_of

if TYPE_CHECKING:
    from optuna.distributions import BaseDistribution

    from graphnav.core.stage import Better


RANDOM_TRIALS = 10
"""Trials of a rival that are drawn at random before the estimator has enough to go by."""


def propose(
    space: Sequence[SearchRange],
    center: Mapping[str, Any],
    tried: Sequence[Trial],
    metrics: Mapping[str, Better],
    n: int,
    seed: int,
) -> list[dict[str, Any]]:
    """Return the parameters of the next ``n`` trials of a rival.

    The proposals depend on what was tried, on the seed and on nothing else, so that a tuning that is resumed goes on
    as it would have. ``center`` has the values of the trial that changes none; where one has no place in its range, as
    null among numbers, nothing is learned from that trial.

    References
    ----------
    .. [TPE] J. Bergstra et al., Algorithms for Hyper-Parameter Optimization, NeurIPS 2011.
    .. [Optuna] T. Akiba et al., Optuna: A Next-generation Hyperparameter Optimization Framework, KDD 2019.
    """
    import optuna

    optuna.logging.set_verbosity(optuna.logging.WARNING)
    spread: dict[str, BaseDistribution] = {one.target: _distribution(one) for one in space}
    sampler = optuna.samplers.TPESampler(seed=_mixed(seed, len(tried)), n_startup_trials=RANDOM_TRIALS)
    study = optuna.create_study(direction="maximize", sampler=sampler)
    for trial, rank in zip(tried, ranks(tried, metrics), strict=True):
        params = center if trial.number == DEFAULT else trial.params
        if all(one.has_place(params[one.target]) for one in space):
            shown = {one.target: one.clipped(params[one.target]) for one in space}
            study.add_trial(optuna.trial.create_trial(params=shown, distributions=spread, value=rank))
    asked = [study.ask(spread).params for _ in range(n)]
    return [{one.target: one.rounded(params[one.target]) for one in space} for params in asked]


def _distribution(searched: SearchRange) -> BaseDistribution:
    from optuna.distributions import CategoricalDistribution, FloatDistribution, IntDistribution

    if searched.kind == "choice":
        return CategoricalDistribution(searched.choices)
    if searched.kind == "integer":
        return IntDistribution(int(searched.low), int(searched.high), log=searched.is_log)
    return FloatDistribution(searched.low, searched.high, log=searched.is_log)


def _mixed(seed: int, n_tried: int) -> int:
    """Return a seed of its own for every batch."""
    return (seed * 1_000_003 + n_tried) % 2**32


BATCH = 5
"""Trials of a rival that are proposed at once. It does not follow the number of processes, so that results do not."""
TRIALS_FOLDER = "trials"
"""Where batches are, below the tuning's folder: each is the folder of a study."""


@dataclass
class TuningRun:
    """The trials so far."""

    tuning: Tuning
    trials: list[Trial] = field(default_factory=list)

    def of(self, rival: Rival) -> list[Trial]:
        """Return the trials of a rival, in the order in which they were made."""
        return [trial for trial in self.trials if trial.rival == rival.label]

    def default(self, rival: Rival) -> Trial:
        """Return the trial that changes nothing."""
        return self.of(rival)[DEFAULT]

    def best(self, rival: Rival) -> Trial:
        """Return the best trial of a rival; of equal ones the first, so that a default is kept unless one beats it."""
        return in_order(self.of(rival), self.tuning.metrics, [self.default(rival)])[0]

    def ranks(self, *, tuned: bool) -> list[list[Rival]]:
        """Return the rivals from the best to the worst, tuned or as they are; equal ones share a rank."""
        rivals = {rival.label: rival for rival in self.tuning.rivals}
        chosen = [self.best(rival) if tuned else self.default(rival) for rival in self.tuning.rivals]
        return [[rivals[trial.rival] for trial in equal] for equal in in_ranks(chosen, self.tuning.metrics)]

    def ranking(self, *, tuned: bool) -> list[Rival]:
        """Return the rivals from the best to the worst; equal ones in their own order."""
        return [rival for equal in self.ranks(tuned=tuned) for rival in equal]

    def has_failed(self) -> bool:
        """Return whether no run of any trial tells anything: all failed or lack the metric that decides."""
        decides = next(iter(self.tuning.metrics))
        return all(trial.values.get(decides, {}).keys() <= trial.failures.keys() for trial in self.trials)


def run_tuning(
    tuning: Tuning,
    folder: Path,
    workers: Workers,
    on_made: Callable[[int], None],
    on_batch: Callable[[TuningRun], None],
) -> TuningRun:
    """Make all trials that are missing in ``folder``, and return all.

    What exists is not run again: a batch follows from the batches before it, so that it is proposed again as it was.

    Parameters
    ----------
    on_made
        Gets the number of runs that were made, or found.
    on_batch
        Gets the trials after every batch.

    Raises
    ------
    UserError
        The folder holds runs of other versions, or another process works in it.
    GraphnavError
        A full disk, a lost cluster. Every finished run is in the folder.
    """
    run = TuningRun(tuning)
    for first in range(0, tuning.request.trials, BATCH):
        proposed = [trial for rival in tuning.rivals for trial in _proposed(run, rival, first)]
        if not proposed:
            break
        checked, refused = tuning.batch(proposed)
        records: Sequence[Record] = ()
        if checked is not None:
            records = _made(checked, folder / TRIALS_FOLDER / f"{first:05d}", workers, on_made)
        on_made(len(refused) * tuning.runs_per_trial)
        plan = tuning.checked.plan
        run.trials += [_with_results(trial, plan, records, refused) for trial in proposed]
        on_batch(run)
    return run


class _WithoutLogs(TaskFactory):
    """Tasks whose runs keep their summaries alone: hundreds of logs would fill the disk."""

    def task(self, job: Job) -> Task:
        """Return what a worker needs to make a run."""
        return replace(super().task(job), keeps_log=False)


def _proposed(run: TuningRun, rival: Rival, first: int) -> list[Trial]:
    """Return the trials of a rival in the batch that begins with trial ``first``."""
    tuning = run.tuning
    numbers = range(first, min(first + BATCH, tuning.n_trials(rival)))
    new = [number for number in numbers if number != DEFAULT]
    params = (
        propose(rival.space, rival.center, run.of(rival), tuning.metrics, len(new), tuning.request.sampler_seed)
        if new
        else []
    )
    default = [Trial(rival.label, DEFAULT, {})] if DEFAULT in numbers else []
    return default + [Trial(rival.label, number, found) for number, found in zip(new, params, strict=True)]


def _made(checked: CheckedStudy, path: Path, workers: Workers, on_made: Callable[[int], None]) -> tuple[Record, ...]:
    """Make the missing runs of a batch and return the results of all."""
    with StudyFolder(path) as folder:
        folder.begin(checked.plan)
        jobs = pending_jobs(checked.plan, folder)
        on_made(checked.plan.n_jobs - len(jobs))
        if jobs:
            execute(jobs, _WithoutLogs(checked), folder, workers, lambda _: on_made(1))
        return read_records(checked.plan, path)


def _with_results(trial: Trial, plan: Plan, records: Sequence[Record], refused: dict[str, str]) -> Trial:
    label = label_of(trial)
    own = [record for record in records if record.variant == label]
    values = {
        metric: {
            (graph, seed): value
            for graph in plan.graphs
            for seed, value in values_of(
                plan, MetricExpression.parse(metric), [record for record in own if record.graph == graph]
            ).items()
        }
        for metric in plan.metrics
    }
    failures = {(record.graph, record.seed): record.cause for record in own if record.outcome == Outcome.FAILED}
    return replace(trial, values=values, refused=refused.get(label, ""), failures=failures)
