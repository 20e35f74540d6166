"""``graphnav teleop``: drive by keyboard."""

from __future__ import annotations

import argparse
import sys

from graphnav.core.cli.options import add_url_option, channel_name, positive, seconds, url_of
from graphnav.core.cli.status import OK
from graphnav.core.cli.status_line import rewrite_line

_EXAMPLES = """\
keys: w s a d, i k j l or the arrows drive; space halts; x stops the robot until r re-arms it; + and - change the
speeds; q quits.

A terminal reports when a key is pressed, but not when it is released: without a repeat within --timeout zero is
published for a moment, then nothing, so that the override of a guard goes stale and the graph drives again.
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.epilog = _EXAMPLES
    parser.add_argument("--channel", type=channel_name, default="TELEOP", help="channel of the twist (default: TELEOP)")
    parser.add_argument("--stop-channel", type=channel_name, default="STOP", help="channel of x and r (default: STOP)")
    parser.add_argument("--speed", type=positive, default=0.3, metavar="MPS", help="forward speed, m/s (default: 0.3)")
    parser.add_argument(
        "--turn", type=positive, default=0.8, metavar="RADPS", help="turning rate, rad/s (default: 0.8)"
    )
    parser.add_argument("--rate", type=positive, default=20.0, metavar="HZ", help="messages per second (default: 20)")
    parser.add_argument(
        "--timeout", type=seconds, default=0.3, metavar="S", help="how long a key press lasts (default: 0.3 s)"
    )
    add_url_option(parser)


def main(args: argparse.Namespace) -> int:
    """Run the command."""
    from graphnav.core.bus import Bus
    from graphnav.core.errors import UserError
    from graphnav.core.keyboard import Terminal
    from graphnav.live.teleop import Drive, Session
    from graphnav.live.teleop.keys import HELP

    if sys.stdin is None or not sys.stdin.isatty():
        raise UserError.of(
            "teleop reads keys, and standard input is not a terminal",
            "run it in a terminal; in scripts use 'graphnav pub'",
        )
    url = url_of(args)
    bus = Bus(url)
    print(f"publishing graphnav_lcm.twist_t on '{args.channel}', stops on '{args.stop_channel}', {url}")
    print(HELP, flush=True)
    drive = Drive(args.speed, args.turn, args.timeout)
    session = Session(bus, args.channel, args.stop_channel, drive, args.rate, _show)
    try:
        with Terminal(sys.stdin.fileno()) as terminal:
            session.run(terminal)
    finally:
        bus.close()
        print()
    return OK


def _show(line: str) -> None:
    """Print a line; in a terminal it replaces the last one and is truncated to the width."""
    if not sys.stdout.isatty():
        print(line, flush=True)
        return
    rewrite_line(line)
