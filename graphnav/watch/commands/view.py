"""``graphnav view``: serve a running graph or a log as a web page, or to Foxglove."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

from graphnav import UserError
from graphnav.core.api import Shared
from graphnav.core.cli import CommandArguments, Exit, Options, port_number
from graphnav.core.parameters import Parameter, command, flag
from graphnav.watch.commands.options import FEED

if TYPE_CHECKING:
    from graphnav.core.catalog import Catalog
    from graphnav.watch.feed import Feed

_PORT = 7667
"""The port number of LCM, which uses it for UDP."""
_FOXGLOVE_PORT = 8765
"""The default port of Foxglove."""
_LOOPBACK = "127.0.0.1"


@command(
    FEED,
    flag(
        "foxglove",
        "--foxglove",
        "serve Foxglove's WebSocket protocol instead of the page (needs the extra 'foxglove')",
    ),
    Parameter(
        "port",
        "--port",
        type=port_number,
        metavar="N",
        help=f"TCP port, 0 for a free one ({_PORT}; with --foxglove {_FOXGLOVE_PORT})",
    ),
    Parameter(
        "host",
        "--host",
        default=_LOOPBACK,
        metavar="ADDRESS",
        help="address to listen on; any other than %(default)s gives other machines access",
    ),
    flag("open", "--open", "open the page, or Foxglove's, in the browser"),
    *Options.TYPES,
    Shared.TRUST,
)
def main(args: CommandArguments) -> int:
    """Run the command."""
    from graphnav.core.notices import print_notice
    from graphnav.watch.commands.listening import complete
    from graphnav.watch.feed import Feed
    from graphnav.watch.view import is_loopback

    catalog = args.catalog()
    args.load_types(catalog)
    feed = complete(Feed(args.feed), catalog, args.plugins)
    if feed.is_live:
        feed.check()
    serve = _serve_foxglove if args.foxglove else _serve_page
    port = args.port if args.port is not None else _FOXGLOVE_PORT if args.foxglove else _PORT
    if not is_loopback(args.host):
        print_notice(f"anyone who can reach {args.host} can watch: remove --host to serve this machine only")
    try:
        serve(feed, catalog, args.host, port, is_opened=args.open)
    except (OSError, UnicodeError) as error:
        number = getattr(error, "errno", None) or 0
        why = os.strerror(number) if number > 0 else getattr(error, "strerror", None) or "not an address"
        what = f"cannot listen on {args.host}, port {port}: {why}"
        raise UserError.of(what, "choose another port with --port, 0 for a free one, or another --host") from error
    return Exit.OK


def _serve_page(feed: Feed, catalog: Catalog, host: str, port: int, *, is_opened: bool) -> None:
    """Serve the page until Ctrl-C."""
    import asyncio

    from graphnav.core.interrupts import plain_ctrl_c
    from graphnav.watch.view import PageFeed, PageServer

    page_feed = PageFeed(feed)

    def ready(url: str) -> None:
        print(f"{feed.name} is shown at {url}  (Ctrl-C exits)", flush=True)
        if is_opened:
            _open(url)

    page_feed.start()
    try:
        with plain_ctrl_c():
            asyncio.run(PageServer(page_feed, catalog).serve(host, port, ready))
    finally:
        page_feed.close()


def _serve_foxglove(feed: Feed, catalog: Catalog, host: str, port: int, *, is_opened: bool) -> None:
    """Serve Foxglove's protocol until Ctrl-C, SIGTERM or SIGHUP."""
    import threading

    from graphnav.watch.view.foxglove import FoxgloveServer

    def ready(url: str, app_url: str) -> None:
        print(f"{feed.name} is served to Foxglove at {url}  (Ctrl-C exits)", flush=True)
        if is_opened:
            _open(app_url)

    FoxgloveServer(feed, catalog).serve(host, port, ready, threading.Event())


def _open(url: str) -> None:
    import webbrowser

    webbrowser.open(url)
