"""``graphnav echo``: print the messages of one channel: as text, JSON lines or CSV."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

from graphnav.core.api import Shared
from graphnav.core.cli import CommandArguments, Exit, Options
from graphnav.core.errors import shown_name
from graphnav.core.notices import print_notice
from graphnav.core.parameters import OneOf, command, flag, many
from graphnav.watch.commands.listening import TIMEOUT_S, Timeout
from graphnav.watch.commands.options import FEED

if TYPE_CHECKING:
    from graphnav.watch.feed import Feed, Watch

_HINT_S = 3.0
"""A longer silence of the channel is reported, once."""

_EXAMPLES = """\
examples:
  graphnav echo control.twist -n 3 --timeout 10
  graphnav echo robot.state runs/a --field x_m --field y_m --csv > path.csv
  graphnav echo flow.flow --field 'uv_px[10][20]' --jsonl
  graphnav echo POSE udpm://239.255.76.67:7667 --types my_lcm_types/
"""


@command(
    Options.CHANNEL,
    FEED,
    Options.MAX_MESSAGES,
    TIMEOUT_S,
    Options.FOR_S.but(help="end after S seconds (default: Ctrl-C, or when its run ends)"),
    many(
        "fields",
        "--field",
        metavar="PATH",
        help="print only a part of each message: a.b, a[0], a[2:8]; may be repeated",
    ),
    OneOf(
        (
            flag("csv", "--csv", "print a table: one row per message, one column per number"),
            flag("jsonl", "--jsonl --json", "print one JSON object per message, for programs"),
        )
    ),
    flag("full", "--full", "print arrays complete instead of summarised"),
    *Options.TYPES,
    Shared.TRUST,
    examples=_EXAMPLES,
)
def main(args: CommandArguments) -> int:
    """Run the command."""
    from graphnav import Place, UserError
    from graphnav.watch.commands.echo_formats import CsvRows, EchoedMessage, JsonLines, Lines
    from graphnav.watch.commands.listening import complete
    from graphnav.watch.feed import Feed, Watch
    from graphnav.watch.fields.field_columns import Selection
    from graphnav.watch.fields.field_path import parse_field

    if args.csv and args.full:
        raise UserError.of("a table has no complete arrays", "use --jsonl --full, or name elements", Place("--csv"))
    paths = [parse_field(text) for text in args.fields]
    catalog = args.catalog()
    args.load_types(catalog)
    feed = complete(Feed(args.feed, [args.channel]), catalog, args.plugins, [args.channel])
    watch = Watch(feed.clock, args.channel)
    form = Lines if not args.jsonl else JsonLines
    printer = CsvRows(paths, feed.epoch_s) if args.csv else form(Selection(paths), feed.epoch_s, full=args.full)
    wait = _Wait(args, feed, watch)
    for received in feed.listen(args.for_s):
        if received is None:
            watch.check(args.channel, feed)
            if wait.is_over():
                break
            continue
        channel = watch.receive(received)
        if received.channel == args.channel:
            values = channel.values if channel.decodes else None
            wait.note(printer.show(EchoedMessage(received, channel.type_name, channel.lcm_class, values)))
            if wait.n_printed == args.count:
                break
    else:
        watch.find(args.channel, feed, args.for_s)
    printer.close()
    return Exit.FAILED if wait.is_cut_short else Exit.OK


class _Wait:
    """Waits for the messages of a live channel: until ``--timeout``, or until the run that sends it has ended."""

    def __init__(self, args: CommandArguments, feed: Feed, watch: Watch) -> None:
        self.n_printed = 0
        self.is_cut_short = False
        """Whether the run ended before there were as many messages as ``-n`` asks for."""
        self._args, self._feed, self._watch = args, feed, watch
        self._timeout = Timeout(args.timeout_s, feed, watch, args.channel)
        self._is_told = False

    def note(self, n_printed: int) -> None:
        """Note that a message was received, of which so much was printed."""
        self.n_printed += n_printed
        self._timeout.note()

    def is_over(self) -> bool:
        """Return whether nothing more will come; tell once that nothing has come yet.

        Raises
        ------
        GraphnavError
            No message of the channel came for as long as ``--timeout`` says.
        """
        if not self._feed.is_live:
            return False
        self._timeout.check()
        from graphnav.watch.feed import RUN_SILENT_S

        name = self._args.channel
        is_heard = self._feed.connected_for_s > RUN_SILENT_S
        if is_heard and (run_id := self._watch.ended_run(name, time.monotonic())):
            print_notice(f"run {shown_name(run_id)} has ended after {self.n_printed} messages on {shown_name(name)}")
            self.is_cut_short = self._args.count is not None
            return True
        if not self._is_told and not self.n_printed and self._timeout.waited_s >= _HINT_S:
            self._is_told = True
            print_notice(f"{self._watch.silence(name, self._feed, _HINT_S)}\n  waiting for it; Ctrl-C exits")
        return False
