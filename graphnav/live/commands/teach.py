"""``graphnav teach``: run an obstacle-free graph and save the learned planar model."""

from __future__ import annotations

import argparse
import math
import shutil
import sys
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from graphnav import UserError
from graphnav.core.api import Shared
from graphnav.core.cli import MAX_FACTOR, CommandArguments, Exit, FailureReport, Options
from graphnav.core.machine import require_linux
from graphnav.core.parameters import Parameter, command, flag

if TYPE_CHECKING:
    from graphnav import Graph
    from graphnav.live.teaching import Coverage, Taught


def coverage(text: str) -> Coverage:
    """Parse a speed in m/s and a turning rate in rad/s, both above 0."""
    from graphnav.live.teaching import Coverage

    try:
        speed, turn = (float(word) for word in text.split(","))
    except ValueError:
        speed = turn = math.nan
    if not (0 < speed <= MAX_FACTOR and 0 < turn <= MAX_FACTOR):
        raise argparse.ArgumentTypeError(f"'{text}' is not a speed and a turning rate above 0, such as 0.3,1.2")
    return Coverage(speed, turn)


@command(
    Shared.GRAPH,
    Shared.SET,
    Shared.PLUGINS,
    Shared.SEED,
    Shared.UNTIL_S,
    Options.PORTABLE,
    Parameter("model", "-o", type=Path, required=True, metavar="FILE", help="the model (.lcmlog)"),
    Shared.LIVE.but(help="teach in wall time; implied by a graph with inputs"),
    Shared.LIVE_URL.but(help="LCM URL of live inputs (default: the graph's, LCM_DEFAULT_URL, this machine's group)"),
    Parameter(
        "until_taught",
        "--until-taught",
        type=coverage,
        metavar="V,W",
        help="live: end once speeds up to V m/s and turning rates up to W rad/s to both sides are taught",
    ),
    flag("force", "--force", "replace FILE if it exists"),
    Options.VERBOSE,
)
def main(args: CommandArguments) -> int:
    """Run the command: save the last planar model published by the graph as a log of one message.

    Ctrl-C discards the result in simulated time, which ends by itself; in a live run it ends teaching.
    """
    from graphnav import PlanarModel

    if args.model.exists() and not args.force:
        raise UserError.of(f"{args.model} already exists", "choose another file, or replace it with --force")
    _, graph = args.load_graph(runs=True)
    learning = [learnt for learnt in graph.channels.values() if learnt.message is PlanarModel]
    if len(learning) != 1:
        raise UserError.of(
            f"{graph.path} has {len(learning)} channels with a planar model, but teaching needs one",
            "end the graph in one planar.teach stage",
        )
    channel = learning[0].name
    is_live = args.live or graph.is_live
    for option, given in (("--url", args.url), ("--until-taught", args.until_taught)):
        if given is not None and not is_live:
            raise UserError.of(
                f"{option} is for live runs, but this graph runs in lockstep", "add --live, or leave it out"
            )
    if is_live:
        require_linux("live runs work")
    with tempfile.TemporaryDirectory() as scratch:
        teach = _teach_live if is_live else _teach
        return teach(graph, Path(scratch), channel, args)


def _teach(graph: Graph, folder: Path, channel: str, args: CommandArguments) -> int:
    from graphnav.core.cli import progress_bar
    from graphnav.core.machine import Console
    from graphnav.core.runner import Outcome, run_recorded
    from graphnav.live.teaching import Taught

    taught, report = Taught(graph, channel), FailureReport(args)
    with progress_bar(Console(stderr=True), graph.path.stem, graph.run.until_s) as on_tick:
        summary = run_recorded(
            graph, graph.make_stages(), folder, keep=[channel], tap=taught, on_tick=on_tick, on_failure=report
        )
    if summary.failure:
        report.print(summary.failure)
        return Exit.FAILED
    if summary.outcome == Outcome.STOPPED:
        print(f"interrupted: teaching was not finished, and {args.model} is not written", file=sys.stderr)
        return Exit.INTERRUPTED
    return _save(folder, channel, args.model, graph, taught)


def _teach_live(graph: Graph, folder: Path, channel: str, args: CommandArguments) -> int:
    from graphnav.core.lcm_url import live_url
    from graphnav.core.machine import Console
    from graphnav.live.run import run_live
    from graphnav.live.teaching import Taught, teaching_progress

    taught, wanted, report = Taught(graph, channel), args.until_taught, FailureReport(args)
    ends = ["Ctrl-C"] if graph.run.until_s is None else [f"{graph.run.until_s:g} s", "Ctrl-C"]
    ends = ends if wanted is None else [f"{wanted.speed_mps:g} m/s and {wanted.turn_radps:g} rad/s are taught", *ends]
    print(f"teaching live on {live_url(graph, args.url)} until {' or '.join(ends)}", file=sys.stderr)
    stages = graph.make_stages()
    with teaching_progress(Console(stderr=True, highlight=False, soft_wrap=True), taught) as show:
        summary = run_live(
            graph,
            stages,
            folder,
            url=args.url,
            keep=[channel],
            tap=taught,
            on_time=show,
            on_failure=report,
            should_stop=lambda: wanted is not None and wanted.is_reached(taught),
        )
    if summary.failure:
        report.print(summary.failure)
        return Exit.FAILED
    return _save(folder, channel, args.model, graph, taught, (summary.live or {}).get("inputs", ()))


def _save(
    folder: Path, channel: str, target: Path, graph: Graph, taught: Taught, inputs: Sequence[Mapping[str, Any]] = ()
) -> int:
    """Write the newest model of a run as a log of one message; say what it holds, and what was not driven.

    ``inputs``: status of the inputs of a live run.
    """
    from graphnav import PlanarModel, Recording
    from graphnav.core.codec import encode
    from graphnav.core.machine import Console
    from graphnav.core.notices import print_notice
    from graphnav.core.record import LogWriter
    from graphnav.core.run_folder import RunFolder
    from graphnav.live.teaching import gaps, why_no_model

    with Recording(folder / RunFolder.LOG) as recording:
        if not recording.count(channel):
            raise UserError.of(f"{graph.path} did not publish a planar model", why_no_model(taught, inputs))
        utime, _, model = recording.message(channel, -1)
    assert isinstance(model, PlanarModel)
    fresh = folder / "model.lcmlog"
    try:
        with LogWriter(fresh) as writer:
            writer.write(channel, utime, encode(model, utime, 0))
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(fresh, target)
    except OSError as error:
        raise UserError.of(f"cannot write {target}: {error.strerror}", "choose another file with -o") from error
    rows, cols = model.valid.shape
    Console(highlight=False, soft_wrap=True).print(
        f"{target}: {', '.join(model.terms)} on {cols} x {rows} cells of {model.step_px} px, "
        f"from {model.frames} frames",
        markup=False,
    )
    for missing in gaps(taught):
        print_notice(f"{missing}: the model does not hold for such motions")
    return Exit.OK
