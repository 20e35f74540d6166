"""``graphnav spy``: show the channels of a live run or a log, full screen if possible, else as a list."""

from __future__ import annotations

import gc
import json
import os
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING

from graphnav.core.api import Shared
from graphnav.core.cli import CommandArguments, Exit, Options
from graphnav.core.parameters import Parameter, command, flag
from graphnav.watch.commands.options import FEED

if TYPE_CHECKING:
    from graphnav.core.catalog import Catalog
    from graphnav.core.machine import Console
    from graphnav.watch.feed import Feed, Watch

_REFRESH_S = 0.5
_PRINT_S = 2.0
_HINT_S = 3.0
"""A longer silence of the group is reported, once."""
_MIN_COLOURS = 8
_PLAIN_TERMINALS = {"dumb", "unknown", ""}


@command(
    FEED,
    flag("once", "--once", "listen for a while, list the channels with their fields and exit"),
    Options.JSON.but(help="print JSON, for programs; implies --once"),
    Options.FOR_S.but(default=2.5, help="how long --once listens (default: %(default)s s)"),
    Parameter(
        "graphics",
        "--graphics",
        choices=("auto", "blocks", "sixel", "kitty"),
        default="blocks",
        help="pictures on the full screen: half blocks, for every terminal; sixels; the kitty protocol; auto "
        "queries the terminal for the best, half blocks inside tmux and screen (default: %(default)s)",
    ),
    *Options.TYPES,
    Shared.TRUST,
)
def main(args: CommandArguments) -> int:
    """Run the command."""
    from graphnav.core.machine import Console
    from graphnav.watch.commands.listening import complete
    from graphnav.watch.feed import Feed, Watch, drops_of
    from graphnav.watch.spy import as_json, as_text

    catalog = args.catalog()
    args.load_types(catalog)
    feed = complete(Feed(args.feed), catalog, args.plugins)
    if not (args.once or args.json) and _has_screen():
        return _full_screen(feed, catalog, args.graphics)
    watch = Watch(feed.clock)
    console = Console(highlight=False, soft_wrap=True)
    if feed.is_live and not (args.once or args.json):
        _watch(feed, watch, console)
        return Exit.OK
    for received in feed.listen(args.for_s):
        if received is not None:
            watch.receive(received)
    if not watch.channels:
        raise feed.silence(args.for_s)
    if args.json:
        print(json.dumps(as_json(watch, feed)))
        return Exit.OK
    heading = f"{feed.name}: {len(watch.channels)} channels" + (f" in {args.for_s:g} s" if feed.is_live else "")
    console.print(as_text(watch, "; ".join([heading, *filter(None, [feed.truncated, drops_of(feed)])])))
    return Exit.OK


def _has_screen() -> bool:
    """Whether this is a terminal for a full screen with keys; the console of Windows is not."""
    if sys.platform == "win32":
        return False
    streams = (sys.__stdin__, sys.__stdout__, sys.__stderr__)
    is_terminal = all(stream is not None and stream.isatty() for stream in streams)
    return is_terminal and os.environ.get("TERM", "dumb") not in _PLAIN_TERMINALS


def _has_colours() -> bool:
    """Whether the terminal's description names colours; an unknown terminal counts as one that has them."""
    import curses

    if os.environ.get("COLORTERM") or sys.__stdout__ is None:
        return True
    try:
        curses.setupterm(fd=sys.__stdout__.fileno())
    except curses.error:
        return True
    return curses.tigetnum("colors") >= _MIN_COLOURS


def _full_screen(feed: Feed, catalog: Catalog, graphics: str) -> int:
    """Show the feed until the user leaves."""
    if not _has_colours():
        os.environ["NO_COLOR"] = "1"
    from graphnav.watch.spy.screen import SpyApp, painters, run_app, watch_of

    gc.freeze()  # imported modules stay: the garbage collector need not scan them
    new_painter = painters(graphics)
    watch = watch_of(feed)
    watch.start()
    try:
        return run_app(SpyApp(watch, catalog, Path.cwd(), new_painter))
    finally:
        watch.close()


def _watch(feed: Feed, watch: Watch, console: Console) -> None:
    """Show one line per channel until Ctrl-C; reprinted below if the terminal cannot move the cursor up."""
    from rich.live import Live

    from graphnav.core.notices import print_notice
    from graphnav.watch.feed import drops_of
    from graphnav.watch.spy import as_text

    begin_s, shown_s, is_told = time.monotonic(), 0.0, False
    with Live(console=console, auto_refresh=False) as live:
        for received in feed.listen(None):
            if received is not None:
                watch.receive(received)
                continue
            if not is_told and not watch.channels and time.monotonic() - begin_s > _HINT_S:
                is_told = True
                print_notice(str(feed.silence(_HINT_S)))
            if time.monotonic() - shown_s > (_PRINT_S if console.is_dumb_terminal else _REFRESH_S):
                shown_s = time.monotonic()
                parts = [f"{feed.name}: {len(watch.channels)} channels", drops_of(feed), feed.failure]
                heading = "; ".join(filter(None, parts))
                text = as_text(watch, heading, with_fields=False)
                if console.is_dumb_terminal:
                    console.print(text)
                else:
                    live.update(text, refresh=True)
