"""The parameters that ``graphnav profile`` and `graphnav.profile` share, beside those of every run."""

from __future__ import annotations

import argparse
from typing import Literal, get_args

from graphnav.core.parameters import Parameter

Clock = Literal["wall", "cpu"]
"""Wall time, or the processor time of the run's thread."""

CLOCK = Parameter(
    "clock",
    "--clock",
    choices=get_args(Clock),
    default="wall",
    help="wall time (default), or processor time of the run's thread: for a machine that does other work",
    doc='What measures: ``"wall"``, or ``"cpu"`` for the processor time of the run, which other work on the '
    "machine hardly changes.",
    example='"cpu" on a machine that does other work',
)
FUNCTIONS = Parameter(
    "functions",
    default=False,
    doc="Also sample the functions inside of the steps, for the flame graph; needs pyinstrument.",
)
"""The command samples them wherever it draws a flame graph and can."""


def percent(text: str) -> float:
    """Parse a share of a core: from 1 to 100 percent."""
    try:
        if 1 <= (value := float(text.removesuffix("%"))) <= 100:
            return value
    except ValueError:
        pass
    raise argparse.ArgumentTypeError(f"'{text}' is not a share of a core, from 1 to 100 percent")
