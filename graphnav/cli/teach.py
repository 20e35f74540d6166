"""``graphnav teach``: run an obstacle-free graph and save the learned planar model."""

from __future__ import annotations

import argparse
import shutil
import sys
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING

from graphnav.cli.options import add_graph_options, add_run_options, load
from graphnav.cli.status import FAILED, INTERRUPTED, OK
from graphnav.errors import UserError

if TYPE_CHECKING:
    from graphnav.graph import Graph
    from graphnav.runner.recording.summary import Summary


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    add_graph_options(parser)
    add_run_options(parser)
    parser.add_argument("-o", dest="model", type=Path, required=True, metavar="FILE", help="the model (.lcmlog)")
    parser.add_argument("--live", action="store_true", help="teach in wall time; implied by a graph with inputs")
    parser.add_argument(
        "--url",
        metavar="URL",
        help="LCM URL of live inputs (default: the graph's, LCM_DEFAULT_URL, this machine's group)",
    )
    parser.add_argument("--force", action="store_true", help="replace FILE if it exists")


def main(args: argparse.Namespace) -> int:
    """Run the command: save the last planar model published by the graph as a log of one message.

    Ctrl-C discards the result in simulated time, which ends by itself; in a live run it ends teaching.
    """
    from rich.console import Console

    from graphnav.codec import encode
    from graphnav.messages import PlanarModel
    from graphnav.record import LOG, LogWriter, Recording
    from graphnav.runner import Outcome

    if args.model.exists() and not args.force:
        raise UserError.of(f"{args.model} already exists", "choose another file, or replace it with --force")
    _, graph = load(args)
    learning = [learnt for learnt in graph.channels.values() if learnt.message is PlanarModel]
    if len(learning) != 1:
        raise UserError.of(
            f"{graph.path} has {len(learning)} channels with a planar model, but teaching needs one",
            "end the graph in one planar.teach stage",
        )
    channel = learning[0].name
    with tempfile.TemporaryDirectory() as scratch:
        summary = _run(graph, Path(scratch), channel, args)
        if summary.failure:
            print(summary.failure, file=sys.stderr)
            return FAILED
        if summary.outcome == Outcome.STOPPED and summary.live is None:
            print(f"interrupted: teaching was not finished, and {args.model} is not written", file=sys.stderr)
            return INTERRUPTED
        with Recording(Path(scratch) / LOG) as recording:
            if not recording.count(channel):
                raise UserError.of(f"{graph.path} did not publish a planar model", _why_none(summary))
            utime, _, model = recording.message(channel, -1)
        assert isinstance(model, PlanarModel)
        fresh = Path(scratch) / "model.lcmlog"
        try:
            with LogWriter(fresh) as writer:
                writer.write(channel, utime, encode(model, utime, 0))
            args.model.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(fresh, args.model)
        except OSError as error:
            raise UserError.of(f"cannot write {args.model}: {error.strerror}", "choose another file with -o") from error
    rows, cols = model.valid.shape
    Console(highlight=False, soft_wrap=True).print(
        f"{args.model}: {', '.join(model.terms)} on {cols} x {rows} cells of {model.step_px} px, "
        f"from {model.frames} frames",
        markup=False,
    )
    return OK


def _run(graph: Graph, folder: Path, channel: str, args: argparse.Namespace) -> Summary:
    from rich.console import Console

    from graphnav.cli.progress import progress_bar
    from graphnav.live import live_url, run_live
    from graphnav.runner.recording.run_recorded import run_recorded

    stages = graph.make_stages()
    if not (args.live or graph.is_live):
        if args.url is not None:
            raise UserError.of("--url is for live runs, but this graph runs in lockstep", "add --live, or leave it out")
        with progress_bar(Console(stderr=True), graph.path.stem, graph.run.until_s) as on_tick:
            return run_recorded(graph, stages, folder, keep=[channel], on_tick=on_tick)
    until = "Ctrl-C" if graph.run.until_s is None else f"{graph.run.until_s:g} s or Ctrl-C"
    print(f"teaching live on {live_url(graph, args.url)} until {until}", file=sys.stderr)
    with progress_bar(Console(stderr=True), graph.path.stem, graph.run.until_s) as on_tick:
        return run_live(
            graph, stages, folder, url=args.url, keep=[channel], on_time=lambda run_s: on_tick(round(run_s * 1e6))
        )


def _why_none(summary: Summary) -> str:
    """Return the hint for a missing model: in a live run an input may have been silent."""
    silent = [one["channel"] for one in (summary.live or {}).get("inputs", ()) if not one["accepted"]]
    if silent:
        return f"no message on {', '.join(silent)}: start its sender, or give its URL with --url"
    return "run it longer with --until"
