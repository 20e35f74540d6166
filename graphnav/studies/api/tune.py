"""``graphnav.tune``: give every rival the same budget to find its parameters, from Python."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from graphnav import Problem
from graphnav.core.api import Argument, KeptFolder, PathLike, Shared
from graphnav.core.catalog import Catalog
from graphnav.core.parameters import documented
from graphnav.core.trust import Trust
from graphnav.studies.ablation.execution import LockedFolder
from graphnav.studies.api.study_arguments import execution_of, names_of, seeds_of, varies_of
from graphnav.studies.api.study_run import workers_of
from graphnav.studies.parameters import FOLDER, METRICS, OF_FUNCTIONS, SAMPLER_SEED, SEARCH, TRIALS
from graphnav.studies.tuning import (
    STUDY,
    TUNING,
    Rival,
    Trial,
    Tuning,
    TuningRequest,
    TuningRun,
    begin_tuning,
    check_tuning,
    conclusion,
    parse_searches,
    run_tuning,
    write_tuning,
)


@dataclass(frozen=True)
class Tuned:
    """The result of `graphnav.tune`."""

    run: TuningRun
    kept: KeptFolder

    @property
    def folder(self) -> Path:
        """The folder; a temporary one is removed with this object."""
        return self.kept.path

    @property
    def study(self) -> Path:
        """The study that compares every rival as it is and tuned, for `graphnav.ablate` in other worlds."""
        return self.folder / STUDY

    @property
    def trials(self) -> tuple[Trial, ...]:
        """All trials."""
        return tuple(self.run.trials)

    @property
    def best(self) -> Mapping[str, Mapping[str, Any]]:
        """The parameters of each rival's best trial, by rival; empty where it is best as it is."""
        return {rival.label: self.run.best(rival).params for rival in self._rivals}

    @property
    def ranking(self) -> tuple[str, ...]:
        """The rivals from the best to the worst, tuned."""
        return tuple(rival.label for rival in self.run.ranking(tuned=True))

    @property
    def _rivals(self) -> tuple[Rival, ...]:
        return self.run.tuning.rivals

    def __repr__(self) -> str:
        return f"<graphnav.Tuned {self.folder}: {conclusion(self.run)}>"


@documented(*Shared.LOADED, *OF_FUNCTIONS)
def tune(
    study: PathLike | Sequence[PathLike],
    *,
    vary: Mapping[str, Sequence[object]] | None = None,
    trials: int = 100,
    seeds: Iterable[int] | None = None,
    metrics: Sequence[str] = (),
    search: Sequence[str] = (),
    set: Mapping[str, object] | None = None,  # noqa: A002 - as --set
    sampler_seed: int = 0,
    plugins: Sequence[PathLike] = (),
    folder: PathLike | None = None,
    jobs: int | None = None,
    cluster: str | None = None,
) -> Tuned:
    """Search the parameters of rivals, the same number of trials for each, in the same worlds.

    The same call resumes an interrupted tuning, and more ``trials`` continue it.

    Raises
    ------
    UserError
        All errors of the request and its graphs; nothing has run then. Seeds from 1000 on are refused.
    GraphnavError
        The tuning was interrupted by a full disk or a lost cluster. Every finished run is in ``folder``.
    KeyboardInterrupt
        Ctrl-C; every finished run is in ``folder``.
    """
    Argument(trials, TRIALS).check_integer()
    Argument(sampler_seed, SAMPLER_SEED).check_integer()
    problems: list[Problem] = []
    request = TuningRequest(
        names=names_of(study),
        varies=varies_of(vary),
        overrides=Argument(set, Shared.SET).overrides(),
        seeds=seeds_of(seeds),
        metrics=Argument(metrics, METRICS).texts(),
        searches=parse_searches(Argument(search, SEARCH).texts(), problems),
        trials=trials,
        sampler_seed=sampler_seed,
        plugins=Argument(plugins, Shared.PLUGINS).paths(),
        problems=problems,
    )
    options = execution_of(jobs, cluster, 0, keep_logs=False, fail_fast=False)
    tuning = check_tuning(request, Catalog(Trust(runs_all=True)).add_files(request.plugins), request.command)
    kept = KeptFolder.temporary() if folder is None else KeptFolder.named(folder, FOLDER)
    return Tuned(tune_into(tuning, kept.path, options.jobs, options.cluster), kept)


def tune_into(
    tuning: Tuning, folder: Path, jobs: int | None, cluster: str | None, on_made: Callable[[int], None] = lambda _: None
) -> TuningRun:
    """Make the missing trials of a tuning in its folder; the files are written after every batch."""
    with LockedFolder(folder, TUNING, "tuning", "graphnav tune") as held:
        begin_tuning(tuning, folder)
        held.empty_scratch()
        with workers_of(jobs, cluster, held.scratch) as workers:
            return run_tuning(tuning, folder, workers, on_made, lambda so_far: write_tuning(so_far, folder))
