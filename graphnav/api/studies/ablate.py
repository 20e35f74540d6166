"""``graphnav.ablate``: run a study from Python."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path

import joblib

from graphnav.ablation.execution import (
    StudyFolder,
    TaskFactory,
    Workers,
    cluster_workers,
    draw_failures,
    execute,
    local_workers,
    pending_drawings,
    pending_jobs,
)
from graphnav.ablation.plan import Plan
from graphnav.ablation.results import read_records, worst_failures
from graphnav.ablation.study import study_of_command
from graphnav.api.arguments import PathLike, path_of, paths_of, set_texts, texts_of, wrong_type
from graphnav.api.load import add_plugins
from graphnav.api.notices import tell
from graphnav.api.result_folder import KeptFolder, temporary_folder
from graphnav.api.studies.finished_study import Study
from graphnav.api.studies.study_files import write_study_files
from graphnav.api.studies.study_plan import checked_plan, names_of, seeds_text, vary_texts, words_of
from graphnav.catalog import Catalog


def ablate(
    study: PathLike | Sequence[PathLike],
    *,
    vary: Mapping[str, Sequence[object]] | None = None,
    set: Mapping[str, object] | None = None,  # noqa: A002 - as --set
    seeds: Iterable[int] | None = None,
    metrics: Sequence[str] = (),
    within: Sequence[str] = (),
    one_at_a_time: bool = False,
    plugins: Sequence[PathLike] = (),
    folder: PathLike | None = None,
    jobs: int | None = None,
    cluster: str | None = None,
    gallery: int = 2,
    keep_logs: bool = False,
) -> Study:
    """Swap stages of graphs, repeat over seeds, compare with statistics; return the tables and the report.

    Runs execute in separate processes, one per core. A failed run is a result. With ``folder``, the same call resumes
    an interrupted study, and more ``seeds`` add runs to the existing ones. There is no confirmation of many runs.

    Parameters
    ----------
    study
        A study (a YAML file, or the name of a shipped one), or graphs: ``"corridor_ccw"``,
        ``["corridor_ccw", "pillars"]``.
    vary
        Axes by override target, the base's value first: ``{"plane": ["plane.ica", "plane.affine"]}``. Axes
        cross. ``{"plane+": ["plane.mine"]}`` adds to an axis of a study.
    set
        Overrides of all runs, as for `graphnav.load`.
    seeds
        Seeds of the worlds, ``range(1000, 1010)``; None: those of the study.
    metrics
        Columns of the tables, ``"drive.success"``, the one that decides first; none: all of them.
    within
        Axes that are conditions: variants are compared with the base under the same one.
    one_at_a_time
        Change one axis of the base at a time instead of crossing the axes.
    plugins
        Files with your own stages.
    folder
        The study's folder. None: a temporary one, removed when the `Study` is no longer in use.
    jobs
        Number of parallel runs; None: one per core.
    cluster
        Scheduler of a Dask cluster that executes the runs, ``"tcp://host:8786"``.
    gallery
        Number of failures of each variant to run again and draw for the report.
    keep_logs
        Keep the full logs of these failures.

    Raises
    ------
    UserError
        All errors of the study and its graphs; nothing has run then.
    GraphnavError
        The study was interrupted by a full disk or a lost cluster. Every finished run is in ``folder``.
    KeyboardInterrupt
        Ctrl-C; every finished run is in ``folder``.
    """
    names, varies, sets, text = names_of(study), vary_texts(vary), set_texts(set), seeds_text(seeds)
    figures, conditions = (
        texts_of(metrics, "metrics", "drive.success"),
        texts_of(within, "within", "control.max_speed_mps"),
    )
    files = paths_of(plugins, "plugins", "my_stage.py")
    _check_count("jobs", jobs, 1)
    _check_count("gallery", gallery, 0)
    if cluster is not None and not isinstance(cluster, str):
        raise wrong_type("cluster", cluster, "a string or None", 'write cluster="tcp://host:8786"')
    kept = None if folder is None else _named(folder)
    catalog = add_plugins(Catalog(), files)
    asked = study_of_command(
        names,
        varies=varies,
        sets=sets,
        metrics=figures,
        within=conditions,
        seeds=text,
        one_at_a_time=one_at_a_time,
    )
    command = words_of(
        names,
        varies=varies,
        sets=sets,
        seeds=text,
        metrics=figures,
        within=conditions,
        one_at_a_time=one_at_a_time,
        plugins=files,
    )
    plan = checked_plan(asked, catalog, command, files)
    kept = kept or temporary_folder()
    _make(plan, catalog, kept.path, jobs=jobs, cluster=cluster, gallery=gallery, keep_logs=keep_logs)
    return Study(plan, write_study_files(plan, kept.path, catalog), kept)


@contextmanager
def study_workers(cluster: str | None, jobs: int | None, scratch: Path) -> Iterator[Workers]:
    """Provide workers: a cluster, or ``jobs`` processes (default: one per core).

    Raises
    ------
    UserError
        Dask is not installed, or no scheduler answers.
    """
    with cluster_workers(cluster) if cluster else local_workers(jobs or joblib.cpu_count(), scratch) as workers:
        yield workers


def _make(
    plan: Plan,
    catalog: Catalog,
    path: Path,
    *,
    jobs: int | None,
    cluster: str | None,
    gallery: int,
    keep_logs: bool,
) -> None:
    """Execute the pending runs of a study and draw its failures."""
    with StudyFolder(path) as folder:
        folder.begin(plan)
        tasks = TaskFactory(plan, catalog)
        with study_workers(cluster, jobs, folder.scratch) as workers:
            execute(pending_jobs(plan, folder), tasks, folder, workers)
            chosen = worst_failures(plan, read_records(plan, folder.path), gallery)
            pending = pending_drawings(chosen, folder, keep_logs=keep_logs)
            for line in draw_failures(pending, tasks, folder, workers, keep_logs=keep_logs):
                tell(line)


def _named(folder: PathLike) -> KeptFolder:
    return KeptFolder(path_of(folder, "folder", "ablations/1").absolute(), is_temporary=False)


def _check_count(name: str, value: object, minimum: int) -> None:
    if value is not None and (isinstance(value, bool) or not isinstance(value, int) or value < minimum):
        raise wrong_type(name, value, f"an integer of at least {minimum}", f"write {name}=2")
