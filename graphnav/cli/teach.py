"""``graphnav teach``: run an obstacle-free graph and save the planar model that it learns."""

from __future__ import annotations

import argparse
import shutil
import sys
import tempfile
from pathlib import Path

from graphnav.cli.options import add_graph_options, add_run_options, load
from graphnav.cli.status import FAILED, INTERRUPTED, OK
from graphnav.errors import UserError


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    add_graph_options(parser)
    add_run_options(parser)
    parser.add_argument(
        "-o", dest="model", type=Path, required=True, metavar="FILE", help="where the model goes (.lcmlog)"
    )
    parser.add_argument("--force", action="store_true", help="replace FILE if it is there")


def main(args: argparse.Namespace) -> int:
    """Run the command: the last planar model that the graph publishes becomes a log of one message."""
    from rich.console import Console  # noqa: PLC0415

    from graphnav.cli.progress import progress_bar  # noqa: PLC0415
    from graphnav.codec import encode  # noqa: PLC0415
    from graphnav.messages import PlanarModel  # noqa: PLC0415
    from graphnav.record import LOG, LogWriter, Recording  # noqa: PLC0415
    from graphnav.runner import Outcome  # noqa: PLC0415
    from graphnav.runner.recorded import run_recorded  # noqa: PLC0415

    if args.model.exists() and not args.force:
        raise UserError.of(f"{args.model} is there already", "choose another file, or replace it with --force")
    _, graph = load(args)
    learning = [learnt for learnt in graph.channels.values() if learnt.message is PlanarModel]
    if len(learning) != 1:
        raise UserError.of(
            f"{graph.path} has {len(learning)} channels with a planar model, but teaching needs one",
            "end the graph in one planar.teach stage",
        )
    channel = learning[0].name
    with tempfile.TemporaryDirectory() as scratch:
        with progress_bar(Console(stderr=True), graph.path.stem, graph.run.until_s) as on_tick:
            summary = run_recorded(graph, graph.make_stages(), Path(scratch), keep=[channel], on_tick=on_tick)
        if summary.failure:
            print(summary.failure, file=sys.stderr)
            return FAILED
        if summary.outcome == Outcome.STOPPED:
            print(f"stopped: teaching was not over, and nothing is written to {args.model}", file=sys.stderr)
            return INTERRUPTED
        with Recording(Path(scratch) / LOG) as recording:
            if not recording.count(channel):
                raise UserError.of(f"{graph.path} published no planar model", "let it run longer with --until")
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
    Console(highlight=False).print(
        f"{args.model}: {', '.join(model.terms)} on {cols} x {rows} cells of {model.step_px} px, "
        f"from {model.frames} frames",
        markup=False,
    )
    return OK
