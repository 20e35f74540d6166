"""Parameters that the commands of this room share, and what is made of their values."""

from __future__ import annotations

import argparse
import math
from pathlib import Path
from typing import TYPE_CHECKING

from graphnav import Place, UserError
from graphnav.core.parameters import Parameter, flag, many
from graphnav.watch.commands.quantities import log_time

if TYPE_CHECKING:
    from graphnav.core.record import ChannelFilter

FEED = Parameter(
    "feed",
    nargs="?",
    metavar="FEED",
    help="another computer where 'graphnav tunnel --serve' runs (HOST: or HOST:PORT), a udpm:// URL, a log or a run "
    "folder (default: where runs are tapped)",
    offers="feeds",
)
LIVE_FEED = FEED.but(
    help="where to listen: another computer where 'graphnav tunnel --serve' runs (HOST: or HOST:PORT), or a udpm:// "
    "URL (default: where runs are tapped)",
    offers="hosts",
)
FROM_S = Parameter(
    "from_s",
    "--from",
    type=log_time,
    default=-math.inf,
    metavar="T",
    help="start at T (12.3s from the start of the log)",
)
TO_S = Parameter("until_s", "--until", type=log_time, default=math.inf, metavar="T", help="end at T")
CHANNELS = (
    many(
        "globs",
        "-c --channel",
        metavar="GLOB",
        help="only channels that match, such as 'robot.*'; may be repeated (default: all)",
        offers="channels",
    ),
    many(
        "regexes",
        "--regex",
        metavar="RE",
        help="only channels whose entire name matches a regular expression; may be repeated",
    ),
    flag("invert", "-v --invert", "only channels that match none of them"),
)
"""For `channels_of`."""


def channel_and_feed(args: argparse.Namespace) -> tuple[str | None, str | None]:
    """Return the channel and the feed; a single word is the feed if it is a URL, a computer, a file or a folder."""
    if args.channel is not None and args.feed is None and _is_feed(args.channel):
        return None, args.channel
    return args.channel, args.feed


def _is_feed(word: str) -> bool:
    from graphnav.watch.feed import host_of

    try:
        return word.startswith("udpm:") or (word != "" and Path(word).exists()) or host_of(word) is not None
    except (OSError, ValueError):  # a name too long, or with a null character
        return False


def channels_of(args: argparse.Namespace) -> ChannelFilter:
    """Return the channels selected by the options.

    Raises
    ------
    UserError
        ``--regex`` is not a regular expression, or ``--invert`` has nothing to invert.
    """
    from graphnav.core.record import ChannelFilter

    if args.invert and not args.globs and not args.regexes:
        raise UserError.of("there is no filter to invert", "add --channel GLOB or --regex RE", Place("--invert"))
    return ChannelFilter(args.globs, args.regexes, invert=args.invert)
