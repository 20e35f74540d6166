"""``graphnav replay``: step the stages of a recorded run again and compare."""

from __future__ import annotations

import argparse
import json
import math
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from graphnav import UserError
from graphnav.core.api import Shared
from graphnav.core.cli import CommandArguments, Exit, FailureReport, Options
from graphnav.core.errors import LogError
from graphnav.core.parameters import Parameter, command, flag, many

if TYPE_CHECKING:
    from graphnav import GraphnavError
    from graphnav.replay.comparison.field_differences import Tolerance


def _words(text: str) -> list[str]:
    words = [word.strip() for word in text.split(",")]
    if all(words):
        return words
    raise argparse.ArgumentTypeError(f"'{text}' does not list channels: write flow.flow,planar.planar")


def _at(text: str) -> float:
    try:
        if 0 <= (value := float(text.removesuffix("s"))) <= 1e9:
            return value
    except ValueError:
        pass
    raise argparse.ArgumentTypeError(f"'{text}' is not a time in seconds: write 12.3s")


def _tolerance(text: str) -> Tolerance:
    from graphnav.replay.comparison.field_differences import Tolerance

    try:
        numbers = [float(part) for part in text.split(",")]
        if len(numbers) <= 2 and all(0 <= number < math.inf for number in numbers):
            return Tolerance(*numbers)
    except ValueError:
        pass
    raise argparse.ArgumentTypeError(f"'{text}' is not a tolerance: write 1e-6, or 1e-6,1e-3 for absolute,relative")


@command(
    Options.RUN_OR_LOG,
    Options.PORTABLE,
    Parameter(
        "graph",
        "--graph",
        metavar="FILE",
        help="step this graph, with the seed of the log (default: the graph of the log)",
    ),
    Shared.SET,
    Shared.PLUGINS,
    Shared.TRUST,
    many(
        "play",
        "--play",
        type=_words,
        metavar="CHANNEL,...",
        help="also play these channels from the log; the stages that write them do not step",
        offers="channels",
    ),
    Parameter(
        "from_s",
        "--from",
        type=_at,
        default=0.0,
        metavar="S",
        help="start of the comparison (12.3s), after warming up from the start of the log",
    ),
    flag("cold", "--cold", "start at --from with fresh state, without warming up"),
    Parameter(
        "tolerance",
        "--tolerance",
        type=_tolerance,
        metavar="ABS[,REL]",
        help="treat numbers as equal up to ABS + REL * |recorded| (default: 0, exact)",
    ),
    Parameter("out", "-o", type=Path, metavar="FILE", help="also write the log of the replay"),
    Options.JSON,
    Options.VERBOSE,
)
def main(args: CommandArguments) -> int:
    """Run the command; the exit status is 1 if anything differs."""
    from graphnav import Recording
    from graphnav.core.cli import damage_told, opened, progress_bar
    from graphnav.core.machine import Console
    from graphnav.core.notices import print_notice
    from graphnav.core.record import find_log
    from graphnav.replay.comparison.field_differences import Tolerance
    from graphnav.replay.comparison.result_text import as_text
    from graphnav.replay.log.log_graph import graph_to_replay
    from graphnav.replay.plan import make_plan, notices_of
    from graphnav.replay.replay import ReplayOptions, replay

    report = FailureReport(args)

    def show_failure(error: GraphnavError) -> None:
        report(error)
        report.print(str(error))

    if args.cold and not args.from_s:
        raise UserError.of("--cold starts at --from with fresh state, but there is no --from", "add --from S")
    log = find_log(args.log)
    catalog = args.catalog()
    play = [word for words in args.play for word in words]
    try:
        recording = opened(log, catalog, args.plugins) if play else Recording(log)
    except LogError as error:
        raise UserError.of(str(error), "name a run folder, or a log") from error
    with recording, damage_told(recording):
        made = graph_to_replay(recording, catalog, graph=args.graph, overrides=args.overrides(), plugins=args.plugins)
        for notice in (*args.notices_of(made.graph), *notices_of(make_plan(made.graph, play))):
            print_notice(notice)
        options = ReplayOptions(play, args.from_s, args.cold, args.tolerance or Tolerance())
        with progress_bar(Console(stderr=True), log.parent.name or log.name, None) as on_tick:
            result = replay(recording, made, options, out=args.out, on_tick=on_tick, on_failure=show_failure)
    for line in result.lost:
        print(f"{result.log}: {line}", file=sys.stderr)
    if args.json:
        print(json.dumps(result.as_json()))
    else:
        console = Console(highlight=False, soft_wrap=True)
        console.print(as_text(result, console), soft_wrap=True)
    return Exit.OK if result.is_equal else Exit.FAILED
