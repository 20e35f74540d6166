"""``graphnav.ablate``: run a study from Python."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext

from graphnav.core.api import Argument, KeptFolder, PathLike, Shared, tell
from graphnav.core.catalog import Catalog
from graphnav.core.parameters import documented
from graphnav.core.trust import Trust
from graphnav.studies.ablation.execution import StudyFolder
from graphnav.studies.ablation.plan import Job
from graphnav.studies.api.finished_study import Study
from graphnav.studies.api.study_arguments import execution_of, names_of, seeds_of, varies_of, worlds_of
from graphnav.studies.api.study_request import StudyRequest
from graphnav.studies.api.study_run import ExecutionOptions, StudyRun, run_study
from graphnav.studies.parameters import FOLDER, METRICS, OF_FUNCTIONS, REFERENCE, WITHIN


@documented(*Shared.LOADED, *OF_FUNCTIONS)
def ablate(
    study: PathLike | Sequence[PathLike],
    *,
    vary: Mapping[str, Sequence[object]] | None = None,
    set: Mapping[str, object] | None = None,  # noqa: A002 - as --set
    seeds: Iterable[int] | None = None,
    metrics: Sequence[str] = (),
    within: Sequence[str] = (),
    one_at_a_time: bool = False,
    reference: str | None = None,
    worlds: Mapping[str, int] | None = None,
    decompose: bool = False,
    until_clear: bool = False,
    plugins: Sequence[PathLike] = (),
    folder: PathLike | None = None,
    jobs: int | None = None,
    cluster: str | None = None,
    gallery: int = 2,
    keep_logs: bool = False,
    fail_fast: bool = False,
) -> Study:
    """Swap stages of graphs, repeat over seeds, compare with statistics; return the tables and the report.

    A failed run is a result. With ``folder``, the same call resumes a study, and more ``seeds`` add runs to it.

    Raises
    ------
    UserError
        All errors of the study and its graphs; nothing has run then.
    GraphnavError
        A full disk, a lost cluster or, with ``fail_fast``, a failed run; every finished run is in ``folder``.
    KeyboardInterrupt
        Ctrl-C; every finished run is in ``folder``.
    """
    request = StudyRequest(
        names=names_of(study),
        varies=varies_of(vary),
        overrides=Argument(set, Shared.SET).overrides(),
        seeds=seeds_of(seeds),
        metrics=Argument(metrics, METRICS).texts(),
        within=Argument(within, WITHIN).texts(),
        one_at_a_time=one_at_a_time,
        decompose=decompose,
        plugins=Argument(plugins, Shared.PLUGINS).paths(),
        reference=reference,
        worlds=worlds_of(worlds),
        until_clear=bool(until_clear),
    )
    options = execution_of(jobs, cluster, gallery, keep_logs, fail_fast)
    return _made(request, None if folder is None else KeptFolder.named(folder, FOLDER), options)


def _made(request: StudyRequest, kept: KeptFolder | None, options: ExecutionOptions) -> Study:
    """Return a study after all its runs were made."""
    Argument(request.reference, REFERENCE).check_text("the name of a variant")
    catalog = Catalog(Trust(runs_all=True)).add_files(request.plugins)
    study = request.check(catalog)
    kept = kept or KeptFolder.temporary()
    with StudyFolder(kept.path) as folder:
        files = run_study(study, catalog, folder, options, _Quiet())
    assert files is not None
    return Study(study.plan, files, kept)


class _Quiet:
    """Accepts all runs and shows no progress."""

    def accept(self, run: StudyRun) -> Sequence[Job]:
        """Return the pending runs."""
        return run.pending()

    def progress(
        self,
        title: str,  # noqa: ARG002
        done: int,  # noqa: ARG002
        total: int,  # noqa: ARG002
        left_s: Callable[[], float | None] | None = None,  # noqa: ARG002
    ) -> AbstractContextManager[Callable[[str], None]]:
        """Return what takes outcomes and shows nothing."""
        return nullcontext(lambda _: None)

    def failed(self, text: str) -> None:
        """Say nothing: a failed run is a result."""

    def tell(self, line: str) -> None:
        """Log a line."""
        tell(line)
