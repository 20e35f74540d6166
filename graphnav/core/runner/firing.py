"""Record of a firing in the log of a live run: the messages that a stage stepped with."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from graphnav.core.codec import encode
from graphnav.core.messages import Fired


class Used(NamedTuple):
    """A message that a stage stepped with.

    ``number``: index of the message in its channel, from 0; -1 for a sampled input before its first message. ``age_s``,
    ``fault``: of a sampled input.
    """

    port: str
    number: int
    utime: int
    age_s: float = 0.0
    fault: str = ""


class Taken(NamedTuple):
    """The inputs of a step by port, the age of the plain ones in seconds, and their messages."""

    inputs: dict[str, Any]
    age_s: float
    used: Sequence[Used]

    def encoded(self, fired_us: int, stage: str, utime: int, seq: int) -> bytes:
        """Return the bytes of the `Fired` of a step at ``utime``."""
        fired = Fired(
            fired_us=fired_us,
            stage=stage,
            age_s=self.age_s,
            ports=tuple(one.port for one in self.used),
            numbers=np.array([one.number for one in self.used], np.int64),
            stamps_us=np.array([one.utime for one in self.used], np.int64),
            ages_s=np.array([one.age_s for one in self.used], np.float64),
            faults=tuple(one.fault for one in self.used),
        )
        return encode(fired, utime, seq)
