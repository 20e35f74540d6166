"""``graphnav view``: a page on this machine that shows a running graph, or a log."""

from __future__ import annotations

import argparse
import os
from typing import TYPE_CHECKING

from graphnav.cli.options import add_feed_argument, add_types_option, load_types_of
from graphnav.cli.status import OK
from graphnav.errors import UserError

if TYPE_CHECKING:
    from graphnav.spy import Feed
    from graphnav.view import Source

_PORT = 7667
"""LCM's own number, which it uses for UDP."""
_LOOPBACK = "127.0.0.1"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    add_feed_argument(parser)
    parser.add_argument(
        "--port", type=_port, default=_PORT, metavar="N", help=f"TCP port of the page, 0 for a free one ({_PORT})"
    )
    parser.add_argument(
        "--host",
        default=_LOOPBACK,
        metavar="ADDRESS",
        help=f"where to listen; any other than {_LOOPBACK} lets other machines watch",
    )
    parser.add_argument("--open", action="store_true", help="open the page in the browser")
    add_types_option(parser)


def main(args: argparse.Namespace) -> int:
    """Run the command."""
    import asyncio  # noqa: PLC0415

    from graphnav.catalog import Catalog  # noqa: PLC0415
    from graphnav.notices import print_notice  # noqa: PLC0415
    from graphnav.spy import Feed  # noqa: PLC0415
    from graphnav.view import PageServer, is_loopback  # noqa: PLC0415

    load_types_of(args)
    feed = Feed(args.feed)
    source = _source_of(feed)
    if not is_loopback(args.host):
        print_notice(f"everybody who can reach {args.host} can watch: leave out --host to serve this machine only")

    def ready(url: str) -> None:
        print(f"{feed.name} is shown at {url}  (Ctrl-C ends)", flush=True)
        if args.open:
            import webbrowser  # noqa: PLC0415

            webbrowser.open(url)

    source.start()
    try:
        asyncio.run(PageServer(source, Catalog()).serve(args.host, args.port, ready))
    except (OSError, UnicodeError) as error:
        number = getattr(error, "errno", None) or 0
        why = os.strerror(number) if number > 0 else getattr(error, "strerror", None) or "not an address"
        what = f"cannot listen on {args.host}, port {args.port}: {why}"
        raise UserError.of(what, "choose another port with --port, 0 for a free one, or another --host") from error
    finally:
        source.close()
    return OK


def _source_of(feed: Feed) -> Source:
    """Return what is watched; raises GraphnavError where nothing can be."""
    from graphnav.view import LiveSource, LogSource  # noqa: PLC0415

    if feed.is_live:
        feed.check()
        return LiveSource(feed)
    log = LogSource(feed.path)
    if not log.n_events:
        raise feed.silence(None)
    return log


def _port(text: str) -> int:
    """Return a TCP port that an option gives."""
    if text.isdecimal() and text.isascii() and int(text) < 65536:
        return int(text)
    raise argparse.ArgumentTypeError(f"'{text}' is not a port: write a number from 0 to 65535")
