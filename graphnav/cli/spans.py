"""Spans of a log as options give them."""

from __future__ import annotations

import argparse
import math

from graphnav.cli.quantities import log_time


def period(text: str) -> float:
    """Return the seconds of ``0.5s``, above 0."""
    if value := log_time(text):
        return value
    raise argparse.ArgumentTypeError(f"'{text}' is not a time above 0: write 0.5s")


def add_span_options(parser: argparse.ArgumentParser, what: str = "") -> None:
    """Declare ``--from`` and ``--until``: seconds since the log begins; ``what``: to what they apply."""
    parser.add_argument(
        "--from",
        dest="from_s",
        type=log_time,
        default=-math.inf,
        metavar="T",
        help=f"{what}leave out what is before T (12.3s since the log begins)",
    )
    parser.add_argument(
        "--until", dest="until_s", type=log_time, default=math.inf, metavar="T", help=f"{what}leave out what is after T"
    )
