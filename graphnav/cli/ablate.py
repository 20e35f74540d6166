"""``graphnav ablate``: swap, repeat over seeds, compare with statistics."""

from __future__ import annotations

import argparse
import shlex
import sys
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

from graphnav.cli.options import add_plugin_option, catalog_of, count
from graphnav.cli.status import INTERRUPTED, OK
from graphnav.errors import CatalogError, GraphnavError, UserError

if TYPE_CHECKING:
    from rich.console import Console

    from graphnav.ablation.plan import Plan
    from graphnav.catalog import Catalog

_ABOUT = """\
A study is a YAML file, the name of a shipped one, or graphs and --vary. Its folder keeps every run: the same command
resumes a study that was interrupted, and a longer range of seeds adds runs to the existing ones.
"""


_OF_RUNS = (
    ("--vary", "varies"), ("--set", "sets"), ("--within", "within"), ("--seeds", "seeds"), ("--figures", "figures"),
    ("--one-at-a-time", "one_at_a_time"), ("--plugin", "plugins"), ("--cluster", "cluster"),
)  # fmt: skip
"""Options that apply only to a study that runs, with the names of their arguments."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    parser.epilog = _ABOUT
    parser.add_argument("names", nargs="*", metavar="STUDY", help="a study, or graphs: files or names of shipped ones")
    parser.add_argument(
        "--vary",
        dest="varies",
        action="append",
        default=[],
        metavar="AXIS=A,B,...",
        help="an axis, the base's value first (plane=plane.ica,plane.affine); AXIS+=C adds a value to the study's",
    )
    parser.add_argument(
        "--set",
        dest="sets",
        action="append",
        default=[],
        metavar="KEY=VALUE",
        help="override in all runs: a stage, a parameter or a wire",
    )
    parser.add_argument("--seeds", metavar="FIRST:END", help="seeds of the worlds, END excluded, or 1,2,5")
    parser.add_argument(
        "--one-at-a-time", action="store_true", help="change one axis of the base at a time instead of crossing"
    )
    parser.add_argument(
        "--within",
        action="append",
        default=[],
        metavar="AXIS,...",
        help="axes that are conditions: variants are compared with the base under the same one",
    )
    parser.add_argument(
        "--figures",
        action="append",
        default=[],
        metavar="STAGE.FIGURE,...",
        help="columns of the table, deciding first",
    )
    add_plugin_option(parser)
    parser.add_argument(
        "-o",
        dest="folder",
        type=Path,
        metavar="DIR",
        help="the study's folder (default: ablations/STUDY); with --compare the file to write",
    )
    parser.add_argument("-j", dest="jobs", type=count, metavar="N", help="runs at once (default: one per core)")
    parser.add_argument(
        "--cluster",
        metavar="URL",
        help="run on the Dask cluster whose scheduler is at tcp://host:8786; its workers need graphnav, and "
        "your maps and plugins at the same paths, but not this folder",
    )
    parser.add_argument(
        "--gallery",
        type=_count_or_none,
        default=2,
        metavar="N",
        help="failures of each variant that are run again and drawn (default 2; controls 1)",
    )
    parser.add_argument("--keep-logs", action="store_true", help="keep the full logs of the drawn failures")
    parser.add_argument("--yes", action="store_true", help="do not ask for confirmation before more than 1000 runs")
    parser.add_argument("--report", type=Path, metavar="DIR", help="rewrite the tables and report of a study's folder")
    parser.add_argument(
        "--compare", nargs=2, type=Path, metavar=("A", "B"), help="compare the studies of two folders, world by world"
    )


def main(args: argparse.Namespace) -> int:
    """Run the command."""
    from rich.console import Console

    from graphnav.ablation.execution import read_plan
    from graphnav.cli.study_output import write_outputs, write_pairing

    _refuse_mixtures(args)
    console = Console(highlight=False, soft_wrap=True)
    if args.compare:
        first, second = args.compare
        write_pairing(first, second, args.folder, console)
        return OK
    if args.report:
        plan = read_plan(args.report)
        write_outputs(plan, args.report, _catalog_of_usable_plugins(plan), console)
        return OK
    if not args.names:
        raise UserError.of("no study is named", "name one: graphnav ablate detectors --seeds 0:10")
    catalog = catalog_of(args)
    return _study(_plan(args, catalog), catalog, args, console)


def _refuse_mixtures(args: argparse.Namespace) -> None:
    """Raise UserError if --report or --compare is combined with options of a study that runs."""
    chosen = [option for option in ("--report", "--compare") if getattr(args, option[2:])]
    if not chosen:
        return
    given = [*args.names, *(option for option, name in _OF_RUNS if getattr(args, name)), *chosen[1:]]
    if args.report and args.folder:
        given.append("-o")
    if given:
        what = f"{chosen[0]} reads an existing study; {', '.join(given)} would have no effect"
        raise UserError.of(what, f"remove {'it' if len(given) == 1 else 'them'}")


def _plan(args: argparse.Namespace, catalog: Catalog) -> Plan:
    """Return the checked plan of the study on the command line."""
    from graphnav.ablation.study import study_of_command
    from graphnav.api.studies.study_plan import checked_plan

    study = study_of_command(
        args.names,
        varies=args.varies,
        sets=args.sets,
        metrics=args.figures,
        within=args.within,
        seeds=args.seeds,
        one_at_a_time=args.one_at_a_time,
    )
    return checked_plan(study, catalog, shlex.join(["graphnav", *args.words]), args.plugins)


def _study(plan: Plan, catalog: Catalog, args: argparse.Namespace, console: Console) -> int:
    """Execute the pending runs of a study, draw its failures, write its report."""
    from graphnav.ablation.execution import StudyFolder, TaskFactory, pending_jobs
    from graphnav.cli.study_output import write_outputs
    from graphnav.cli.study_run import draw_worst, make_missing, workers_of

    with StudyFolder(args.folder or Path("ablations") / plan.name) as folder:
        try:
            folder.begin(plan)
            tasks = TaskFactory(plan, catalog)
            with workers_of(args.cluster, args.jobs, folder) as workers:
                if not make_missing(plan, tasks, folder, workers, console, is_sure=args.yes):
                    return OK
                draw_worst(plan, tasks, folder, workers, console, each=args.gallery, keep_logs=args.keep_logs)
            write_outputs(plan, folder.path, catalog, console)
        except KeyboardInterrupt:
            print(
                f"stopped: {_state(plan, len(pending_jobs(plan, folder)))}; resume with the same command",
                file=sys.stderr,
            )
            return INTERRUPTED
        except UserError:
            raise
        except GraphnavError as error:
            state = _state(plan, len(pending_jobs(plan, folder)))
            raise GraphnavError(f"{error}\n  {state}; fix this and resume with the same command") from error
    return OK


def _catalog_of_usable_plugins(plan: Plan) -> Catalog:
    """Return the catalog with the usable plugin files of a study: only drawings need them."""
    from graphnav.catalog import Catalog

    catalog = Catalog()
    for plugin in plan.plugins:
        with suppress(CatalogError):
            catalog.add_file(Path(plugin))
    return catalog


def _state(plan: Plan, n_missing: int) -> str:
    return f"{plan.n_jobs - n_missing} of {plan.n_jobs} runs are finished"


def _count_or_none(text: str) -> int:
    return 0 if text == "0" else count(text)
