"""Options that select a time span of a log."""

from __future__ import annotations

import argparse
import math

from graphnav.core.cli.quantities import log_time


def period(text: str) -> float:
    """Parse a period above 0, ``0.5s``, into seconds."""
    if (value := log_time(text)) >= 1e-6:
        return value
    raise argparse.ArgumentTypeError(f"'{text}' is not a time above 0: write 0.5s")


def add_span_options(parser: argparse.ArgumentParser, what: str = "") -> None:
    """Declare ``--from`` and ``--until``, seconds from the start of the log; ``what``: what they apply to."""
    parser.add_argument(
        "--from",
        dest="from_s",
        type=log_time,
        default=-math.inf,
        metavar="T",
        help=f"{what}start at T (12.3s from the start of the log)",
    )
    parser.add_argument("--until", dest="until_s", type=log_time, default=math.inf, metavar="T", help=f"{what}end at T")
