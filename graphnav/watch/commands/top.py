"""``graphnav top``: show the health of running graphs: rates, latencies, drops, state of the guard."""

from __future__ import annotations

import json
import time
from typing import TYPE_CHECKING

from graphnav.core.cli import CommandArguments, Exit, Options
from graphnav.core.parameters import command, flag
from graphnav.watch.commands.options import FEED

if TYPE_CHECKING:
    from rich.console import RenderableType

    from graphnav import GraphnavError
    from graphnav.core.machine import Console
    from graphnav.watch.feed import Feed, Health

_REFRESH_S = 0.5
_PIPED_COLS = 160
_EVERY_RUN_S = 1.5
"""Every healthy run sends a status within this time."""
_KEYS = (("space", "freeze the view, or go on"), ("?", "show the keys, or hide them"), ("q", "quit"))


@command(
    FEED,
    flag("once", "--once", "wait for one status of each run, print it and exit"),
    Options.JSON.but(help="print JSON, for programs; implies --once"),
    Options.FOR_S.but(
        default=2.5,
        help="how long to wait for the first status before reporting that there is none (default: %(default)s s)",
    ),
    *Options.TYPES,
    about="keys: " + "; ".join(f"{key}: {what}" for key, what in _KEYS),
)
def main(args: CommandArguments) -> int:
    """Run the command."""
    from graphnav.core.machine import Console
    from graphnav.watch.feed import Feed, Health
    from graphnav.watch.spy import health_as_json, health_as_text

    args.load_types()
    feed = Feed(args.feed, ())
    health = Health(feed.clock)
    console = Console(highlight=False)
    if not console.is_terminal:
        console = Console(highlight=False, width=_PIPED_COLS)
    if feed.is_live and not (args.once or args.json):
        _watch(feed, health, console, args.for_s)
        return Exit.OK
    _look(feed, health, args.for_s)
    if not health.has_status:
        raise _no_run(feed, health, args.for_s)
    if args.json:
        print(json.dumps(health_as_json(health, feed.name)))
    else:
        console.print(health_as_text(health, console.width))
    return Exit.OK


def _look(feed: Feed, health: Health, for_s: float) -> None:
    """Listen until every run has sent a status, or to the end of a log."""
    begin_s = time.monotonic()
    for received in feed.listen(for_s):
        if received is not None:
            health.receive(received)
        elif health.is_complete and time.monotonic() - begin_s > _EVERY_RUN_S:
            return


def _watch(feed: Feed, health: Health, console: Console, for_s: float) -> None:
    """Show the runs until q or Ctrl-C; report once, after ``for_s``, that there is none."""
    from rich.live import Live

    from graphnav.core.notices import print_notice
    from graphnav.watch.commands.foreground_keyboard import open_keyboard

    begin_s, shown_s, is_new, is_told = time.monotonic(), 0.0, False, False
    with open_keyboard() as (keyboard, has_keys), Live(console=console, auto_refresh=False) as live:
        view = _View(feed, health, has_keys=has_keys)
        for received in feed.listen(None):
            if received is not None:
                is_new |= health.receive(received)
                continue
            is_pressed = view.press(keyboard.read(0.0) or b"")
            if view.is_left:
                return
            if health.has_status:
                if is_pressed or is_new or time.monotonic() - shown_s > _REFRESH_S:
                    shown_s, is_new = time.monotonic(), False
                    live.update(view.shown(console.width), refresh=True)
            elif not is_told and time.monotonic() - begin_s > for_s:
                is_told = True
                print_notice(f"{_no_run(feed, health, for_s)}\n  waiting for it; Ctrl-C exits")


class _View:
    """The content of the screen, as the keys choose it."""

    def __init__(self, feed: Feed, health: Health, *, has_keys: bool) -> None:
        from graphnav.core.keyboard import KeyDecoder

        self.is_left = False
        self._feed, self._health, self._has_keys = feed, health, has_keys
        self._decoder = KeyDecoder()
        self._shows_keys = self._is_frozen = False
        self._body: RenderableType = ""

    def press(self, data: bytes) -> bool:
        """Handle the bytes of keys; return whether they change what is shown."""
        keys = self._decoder.feed(data)
        self._shows_keys ^= keys.count("?") % 2 == 1
        self._is_frozen ^= keys.count(" ") % 2 == 1
        self.is_left |= "q" in keys
        return bool(keys)

    def shown(self, width_cols: int) -> RenderableType:
        """Return the screen: a heading, the keys if they are asked for, and the runs."""
        from rich.console import Group
        from rich.text import Text

        from graphnav.watch.spy import health_as_text

        if not self._is_frozen:
            self._body = health_as_text(self._health, width_cols)
        if not self._has_keys:
            return self._body
        heading = Text.assemble(("graphnav top", "bold"), f"  {self._feed.name.partition('?')[0]}  ", ("? keys", "dim"))
        heading.append_text(Text("  FROZEN", "bold reverse") if self._is_frozen else Text())
        heading.append(f"\n{self._feed.failure}" if self._feed.failure else "", "red")
        keys = [Text.assemble((f"{key:>8}", "bold"), f"  {what}") for key, what in _KEYS] if self._shows_keys else []
        return Group(heading, *keys, self._body)


def _no_run(feed: Feed, health: Health, for_s: float) -> GraphnavError:
    from graphnav import GraphnavError
    from graphnav.core.errors import shown_name

    if feed.failure:
        return feed.silence(for_s)
    if not feed.is_live:
        return GraphnavError(f"{feed.name} does not contain a status of a run: only live runs record it")
    if health.runs:
        runs = ", ".join(map(shown_name, sorted(health.runs)))
        return GraphnavError(f"no status within {for_s:g} s of run {runs}, which is received on {feed.name}")
    return GraphnavError(f"no run on {feed.name} within {for_s:g} s: start one with 'graphnav run GRAPH --live'")
