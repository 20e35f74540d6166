"""``graphnav play``: publish the messages of a log again."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

from graphnav.core.api import Shared
from graphnav.core.cli import CommandArguments, Exit, Options, StatusLine, counted, positive
from graphnav.core.errors import shown_name
from graphnav.core.parameters import Parameter, command, flag
from graphnav.watch.commands.options import CHANNELS, channels_of
from graphnav.watch.commands.quantities import log_time

if TYPE_CHECKING:
    from graphnav import Recording
    from graphnav.watch.log_cursor import LogCursor
    from graphnav.watch.player import Player

_EXAMPLES = """\
examples:
  graphnav play runs/corridor_ccw-1                      at the recorded pace, on this machine's group
  graphnav play drive.lcmlog --start 12.3s --end 20s --speed 0.5 --loop
  graphnav play drive.lcmlog -c 'robot.*' --url udpm://239.255.1.1:7667

In a terminal keys pause, step and seek. Nothing leaves this machine unless the URL says ttl=1 or more.
"""


@command(
    Options.LOG,
    Parameter("speed", "--speed", type=positive, default=1.0, metavar="X", help="speed factor (default: %(default)g)"),
    Parameter(
        "start", "--start", type=log_time, default=0.0, metavar="TIME", help="start of the playback, such as 12.3s"
    ),
    Parameter("end", "--end", type=log_time, metavar="TIME", help="end of the playback, such as 20s or 2min"),
    flag("loop", "--loop", "restart at the end, until Ctrl-C"),
    *CHANNELS,
    Options.URL,
    Shared.TRUST,
    examples=_EXAMPLES,
)
def main(args: CommandArguments) -> int:
    """Run the command."""
    from graphnav.core.bus import Bus
    from graphnav.core.catalog import Catalog
    from graphnav.core.cli import opened
    from graphnav.core.notices import print_notice
    from graphnav.core.record import find_log
    from graphnav.watch.commands.foreground_keyboard import open_keyboard
    from graphnav.watch.player import HELP, Player, select_events

    channels = channels_of(args)
    url = args.lcm_url()
    with opened(find_log(args.log), Catalog(args.trusted())) as recording:
        channels = channels.without(recording.foreign_types)
        cursor = select_events(recording, channels, args.start, args.end, loop=args.loop)
        cursor.set_speed(args.speed)
        _tell(recording, cursor)
        bus = Bus(url)
        status = StatusLine()

        def notice(text: str) -> None:
            status.clear()
            print_notice(text)

        player = Player(cursor, bus.send, notice=notice, show=lambda: status.show(_status(player)))
        what = f"{counted(len(cursor), 'message')} on {counted(len(cursor.channels), 'channel')}"
        length_s = (cursor.end_us - cursor.begin_us) / 1e6
        print(f"playing {recording.path}: {what}, {length_s:.1f} s, {args.speed:g}x\n  on {url}", flush=True)
        begin_s = time.monotonic()
        try:
            with open_keyboard() as (keyboard, has_keys), status:
                if has_keys:
                    print(HELP, flush=True)
                player.play(keyboard)
        finally:
            bus.close()
            print(f"{counted(player.n_played, 'message')} played in {time.monotonic() - begin_s:.1f} s")
    if player.n_refused:
        print_notice(f"not published: {counted(player.n_refused, 'message')}: {shown_name(player.refusal)}")
    return Exit.FAILED if player.n_refused and not player.n_played else Exit.OK


def _tell(recording: Recording, cursor: LogCursor) -> None:
    """Say what is damaged, and what would move a robot that listens."""
    from graphnav.core.notices import print_notice
    from graphnav.watch.player import motor_channels

    if notice := recording.damage_notice():
        print_notice(notice)
    if foreign := recording.foreign_types:
        told = ", ".join(f"{shown_name(topic)} ({shown_name(kind)})" for topic, kind in foreign.items())
        print_notice(f"not played, since graphnav has no such types: {told}")
    motors = {channel: ref for channel, ref in motor_channels(recording).items() if channel in cursor.channels}
    for channel, ref in motors.items():
        name = shown_name(channel)
        print_notice(
            f"'{name}' is a motor channel ({shown_name(ref)}): a listening robot will move\n"
            f"  exclude it with --invert --channel '{name}'"
        )


def _status(player: Player) -> str:
    cursor = player.cursor
    state = "paused " if cursor.is_paused else "playing"
    behind = f"  {player.behind_s:.1f} s behind" if player.behind_s else ""
    return (
        f"{state}  {cursor.at_us / 1e6:.1f} of {cursor.end_us / 1e6:.1f} s  {cursor.speed_ratio:g}x  "
        f"{counted(player.n_played, 'message')}{behind}"
    )
