"""``graphnav echo``: print the messages of one channel: as text, JSON lines or CSV."""

from __future__ import annotations

import argparse

from graphnav.cli.options import add_feed_argument, add_types_option, count, load_types_of, seconds
from graphnav.cli.status import OK

_EXAMPLES = """\
examples:
  graphnav echo control.twist -n 3
  graphnav echo robot.state runs/a --field x_m --field y_m --csv > path.csv
  graphnav echo flow.flow --field 'uv_px[10][20]' --jsonl
  graphnav echo POSE udpm://239.255.76.67:7667 --types my_lcm_types/
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.epilog = _EXAMPLES
    parser.add_argument("channel", metavar="CHANNEL", help="the channel's name")
    add_feed_argument(parser)
    parser.add_argument("-n", dest="count", type=count, metavar="N", help="end after N messages")
    parser.add_argument("--for", dest="for_s", type=seconds, metavar="S", help="end after S seconds (default: Ctrl-C)")
    parser.add_argument(
        "--field",
        dest="fields",
        action="append",
        default=[],
        metavar="PATH",
        help="print only a part of each message: a.b, a[0], a[2:8]; may be repeated",
    )
    out = parser.add_mutually_exclusive_group()
    out.add_argument("--csv", action="store_true", help="print a table: one row per message, one column per number")
    out.add_argument(
        "--jsonl", "--json", dest="jsonl", action="store_true", help="print one JSON object per message, for programs"
    )
    parser.add_argument("--full", action="store_true", help="print arrays complete instead of summarised")
    add_types_option(parser)


def main(args: argparse.Namespace) -> int:
    """Run the command."""
    from graphnav.cli.echo_formats import CsvRows, EchoedMessage, JsonLines, Lines
    from graphnav.cli.opened_log import complete
    from graphnav.errors import Place, UserError
    from graphnav.spy import Feed, Selection, Traffic, parse_field

    if args.csv and args.full:
        raise UserError.of("a table has no complete arrays", "use --jsonl --full, or name elements", Place("--csv"))
    paths = [parse_field(text) for text in args.fields]
    load_types_of(args)
    feed = complete(Feed(args.feed), [args.channel])
    traffic = Traffic(feed.clock, args.channel)
    form = Lines if not args.jsonl else JsonLines
    printer = CsvRows(paths, feed.epoch_s) if args.csv else form(Selection(paths), feed.epoch_s, full=args.full)
    n_printed = 0
    for received in feed.listen(args.for_s):
        if received is None:
            traffic.check(args.channel, feed)
            continue
        channel = traffic.receive(received)
        if received.channel == args.channel:
            values = channel.values if channel.decodes else None
            n_printed += printer.show(EchoedMessage(received, channel.type_name, channel.lcm_class, values))
            if n_printed == args.count:
                break
    else:
        traffic.find(args.channel, feed, args.for_s)
    printer.close()
    return OK
