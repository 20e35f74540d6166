"""What ``run:`` may say."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from graphnav.stage import param


@dataclass(frozen=True, kw_only=True)
class RunOptions:
    """How a graph runs, where the command line says nothing else."""

    until_s: float | None = param(None, gt=0.0, le=1e9, doc="when to stop; null runs until a source finishes")
    seed: int = param(0, ge=0, le=4_294_967_295, doc="all randomness of a run derives from it")
    record: Literal["all", "small"] | None = param(
        None,
        doc="what the log keeps; small: messages below 4 kB, and the first of every channel; null: all in lockstep, "
        "small live",
    )
    url: str | None = param(
        None,
        doc="LCM URL of the channels that leave and come in, live; null: LCM_DEFAULT_URL, else this machine's group",
    )
