"""``graphnav ablate``: swap, repeat over seeds, compare with statistics."""

from __future__ import annotations

import shlex
import sys
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

from graphnav import GraphnavError, Problem, UserError, shown_path
from graphnav.core.api import Shared
from graphnav.core.cli import CommandArguments, Exit, Options
from graphnav.core.errors import CatalogError
from graphnav.core.interrupts import ended_by_interrupt
from graphnav.core.notices import print_notice
from graphnav.core.parameters import Parameter, command, former, many
from graphnav.studies.parameters import (
    CLUSTER,
    DECOMPOSE,
    FAIL_FAST,
    FOLDER,
    GALLERY,
    JOBS,
    KEEP_LOGS,
    METRICS,
    ONE_AT_A_TIME,
    REFERENCE,
    SEEDS,
    STALL_S,
    STUDY,
    UNTIL_CLEAR,
    VARY,
    WITHIN,
    WORLDS,
    YES,
)

if TYPE_CHECKING:
    from graphnav.core.catalog import Catalog
    from graphnav.core.machine import Console
    from graphnav.studies.ablation.plan import CheckedStudy, Plan
    from graphnav.studies.api.study_request import StudyRequest

_ABOUT = """\
A study is a YAML file, the name of a shipped one, or graphs and --vary. Its folder keeps every run: the same command
resumes a study that was interrupted, and a longer range of seeds adds runs to the existing ones. Logs keep small
messages, which is too little for replay: --set run.record=replayable keeps what it needs, with the images.
"""
_OF_RUNS = (
    *(VARY, Shared.SET, WITHIN, SEEDS, METRICS, REFERENCE, WORLDS),
    *(UNTIL_CLEAR, ONE_AT_A_TIME, DECOMPOSE, Shared.PLUGINS, CLUSTER),
)
"""Options that apply only to a study that runs."""


@command(
    Options.PORTABLE,
    STUDY,
    VARY,
    Shared.SET.but(help="override in all runs: a stage, a parameter or a wire"),
    ONE_AT_A_TIME,
    DECOMPOSE,
    WITHIN,
    SEEDS,
    UNTIL_CLEAR,
    WORLDS,
    REFERENCE,
    METRICS,
    former("--figures", "--metrics"),
    Shared.PLUGINS,
    FOLDER,
    JOBS,
    CLUSTER,
    GALLERY,
    KEEP_LOGS,
    FAIL_FAST,
    STALL_S,
    YES,
    Shared.TRUST,
    Parameter("report", "--report", type=Path, metavar="DIR", help="rewrite the tables and report of a study's folder"),
    Parameter(
        "export",
        "--export",
        choices=("mlflow",),
        help="with --report: also write an MLflow run for each case (extra: mlflow) on MLFLOW_TRACKING_URI",
    ),
    Parameter(
        "compare",
        "--compare",
        nargs=2,
        type=Path,
        metavar=("A", "B"),
        help="compare the studies of two folders, world by world",
    ),
    many(
        "contrasts",
        "--contrast",
        metavar="A,B",
        help="compare two variants of the study, or with --report of an existing one, in every metric",
    ),
    many(
        "fail_if",
        "--fail-if",
        metavar="CONDITION",
        help="with --compare: exit status 1 if the difference B - A of any case meets it: 'drive.success < -0.05' for "
        "the mean, 'high(drive.success) < 0' for the upper end of its interval; may be given several times",
    ),
    about=_ABOUT,
)
def main(args: CommandArguments) -> int:
    """Run the command."""
    from graphnav.core.machine import Console
    from graphnav.studies.ablation.execution import read_plan
    from graphnav.studies.ablation.results import parse_pairs
    from graphnav.studies.api.mlflow_export import export_to_mlflow
    from graphnav.studies.api.study_files import write_study_files
    from graphnav.studies.commands.study_output import print_outputs, study_status, write_pairing

    _refuse_mixtures(args)
    console = Console(highlight=False, soft_wrap=True)
    if args.compare:
        first, second = args.compare
        return write_pairing(first, second, args.folder, args.fail_if, console)
    if args.report:
        plan = read_plan(args.report)
        pairs = parse_pairs(args.contrasts, plan.variants)
        files = write_study_files(plan, args.report, _catalog_of_usable_plugins(args, plan))
        print_outputs(plan, args.report, files, console, pairs)
        if args.export:
            console.print(f"mlflow: {export_to_mlflow(plan, files, args.report)}", markup=False)
        return study_status(files)
    if not args.study:
        raise UserError.of("no study is named", "name one: graphnav ablate detectors --seeds 0:10")
    with ended_by_interrupt(owns_process=args.owns_process):
        catalog = args.catalog(runs_all=True)
        study = _request(args).check(catalog, shlex.join(["graphnav", *args.words]))
    return _run(study, catalog, args, console)


def _refuse_mixtures(args: CommandArguments) -> None:
    """Raise UserError if --report or --compare is combined with options of a study that runs."""
    if args.trust and not args.report:
        raise UserError.of("--trust is for --report: studies run what they name", "remove it, or add --report DIR")
    if args.fail_if and not args.compare:
        raise UserError.of("--fail-if is for --compare, which compares two studies", "add --compare A B")
    if args.export and not args.report:
        raise UserError.of("--export is for --report, which reads an existing study", "add --report DIR")
    chosen = [option for option in ("--report", "--compare") if getattr(args, option[2:])]
    if not chosen:
        return
    given = [*args.study, *(option.flag for option in _OF_RUNS if getattr(args, option.name)), *chosen[1:]]
    given += ["--contrast"] if args.compare and args.contrasts else []
    if args.report and args.folder:
        given.append("-o")
    if given:
        what = f"{chosen[0]} reads an existing study; {', '.join(given)} would have no effect"
        raise UserError.of(what, f"remove {'it' if len(given) == 1 else 'them'}")


def _request(args: CommandArguments) -> StudyRequest:
    """Return the study that the command line asks for."""
    from graphnav.core.graph import Override
    from graphnav.studies.ablation.study import parse_varies, parse_worlds
    from graphnav.studies.api.study_request import StudyRequest

    problems: list[Problem] = []
    return StudyRequest(
        names=args.study,
        varies=parse_varies(args.vary, problems),
        overrides=Override.parse_all(args.set, problems),
        seeds=args.seeds,
        metrics=args.metrics,
        within=args.within,
        one_at_a_time=args.one_at_a_time,
        decompose=args.decompose,
        plugins=args.plugins,
        reference=args.reference,
        worlds=parse_worlds(args.worlds, problems),
        until_clear=args.until_clear,
        problems=problems,
    )


def _run(study: CheckedStudy, catalog: Catalog, args: CommandArguments, console: Console) -> int:
    """Make the pending runs of a study, draw its failures, write its report."""
    from graphnav.studies.ablation.execution import StudyFolder, pending_jobs
    from graphnav.studies.ablation.results import parse_pairs
    from graphnav.studies.api.study_run import ExecutionOptions, FailFastError, run_study
    from graphnav.studies.commands.study_output import print_outputs, study_status
    from graphnav.studies.commands.study_run import StudyConsole

    plan, pairs = study.plan, parse_pairs(args.contrasts, study.plan.variants)
    options = ExecutionOptions(
        args.jobs, args.cluster, args.gallery, args.keep_logs, fail_fast=args.fail_fast, stall_s=args.stall_s
    )
    with StudyFolder(args.folder or Path("ablations") / plan.name) as folder:
        try:
            files = run_study(study, catalog, folder, options, StudyConsole(console, is_sure=args.yes))
            if files is not None:
                print_outputs(plan, folder.path, files, console, pairs)
                return study_status(files)
        except KeyboardInterrupt:
            state = _state(plan, len(pending_jobs(plan, folder)))
            print(f"stopped: {state}; resume with the same command", file=sys.stderr)
            return Exit.INTERRUPTED
        except UserError:
            raise
        except FailFastError as error:
            state = _state(plan, len(pending_jobs(plan, folder)))
            hint = f"graphnav ablate --report {shlex.quote(shown_path(folder.path))} writes their tables"
            raise GraphnavError(f"{error}\nstopped by --fail-fast: {state}; {hint}") from error
        except GraphnavError as error:
            state = _state(plan, len(pending_jobs(plan, folder)))
            raise GraphnavError(f"{error}\n  {state}; fix this and resume with the same command") from error
    return Exit.OK


def _catalog_of_usable_plugins(args: CommandArguments, plan: Plan) -> Catalog:
    """Return the catalog with the usable and trusted plugin files of a study: only drawings need them."""
    from graphnav.core.catalog import Catalog
    from graphnav.core.trust import Request, read_plugin

    catalog = Catalog(args.trusted())
    sources: dict[Path, bytes] = {}
    for plugin in map(Path, plan.plugins):
        with suppress(OSError):
            sources[plugin] = read_plugin(plugin)
    request = Request.of_plan(args.report, sources)
    if sources and not catalog.trust.allows(request):
        for plugin in sources:
            advice = catalog.trust.advice(request)
            print_notice(f"left out: plugin {plugin}, Python code that is not trusted\n  {advice}")
        return catalog
    for plugin, source in sources.items():
        with suppress(CatalogError):
            catalog.add_file(plugin, source)
    return catalog


def _state(plan: Plan, n_missing: int) -> str:
    return f"{plan.n_jobs - n_missing} of {plan.n_jobs} runs are finished"
