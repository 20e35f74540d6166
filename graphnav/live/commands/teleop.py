"""``graphnav teleop``: drive by keyboard."""

from __future__ import annotations

import sys

from graphnav.core.cli import CommandArguments, Exit, Options, StatusLine, channel_name, positive
from graphnav.core.parameters import Parameter, command, seconds

_EXAMPLES = """\
keys: w s a d, i k j l or the arrows drive; space halts; x stops the robot until r re-arms it; + and - change the
speeds; q quits.

A terminal reports when a key is pressed, but not when it is released: without a repeat within --timeout zero is
published for a moment, then nothing, so that the override of a guard goes stale and the graph drives again.
"""


@command(
    Parameter(
        "channel", "--channel", type=channel_name, default="TELEOP", help="channel of the twist (default: %(default)s)"
    ),
    Parameter(
        "stop_channel",
        "--stop-channel",
        type=channel_name,
        default="STOP",
        help="channel of x and r (default: %(default)s)",
    ),
    Parameter(
        "speed", "--speed", type=positive, default=0.3, metavar="MPS", help="forward speed, m/s (default: %(default)s)"
    ),
    Parameter(
        "turn", "--turn", type=positive, default=0.8, metavar="RADPS", help="turning rate, rad/s (default: %(default)s)"
    ),
    Parameter(
        "rate", "--rate", type=positive, default=20.0, metavar="HZ", help="messages per second (default: %(default)g)"
    ),
    Parameter(
        "timeout",
        "--timeout",
        type=seconds,
        default=0.3,
        metavar="S",
        help="how long a key press lasts (default: %(default)s s)",
    ),
    Options.URL,
    examples=_EXAMPLES,
)
def main(args: CommandArguments) -> int:
    """Run the command."""
    from graphnav import UserError
    from graphnav.core.bus import Bus
    from graphnav.core.keyboard import Terminal
    from graphnav.live.teleop import HELP, Drive, Session

    if sys.stdin is None or not sys.stdin.isatty():
        raise UserError.of(
            "teleop reads keys, and standard input is not a terminal",
            "run it in a terminal; in scripts use 'graphnav pub'",
        )
    url = args.lcm_url()
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
    return Exit.OK


def _show(line: str) -> None:
    """Print a line; in a terminal it replaces the last one and is truncated to the width."""
    if not sys.stdout.isatty():
        print(line, flush=True)
        return
    StatusLine.rewrite(line)
