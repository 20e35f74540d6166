"""What a study decomposes: the stages of a drive, each swapped for its oracle."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import accumulate

AXIS, BASE = "oracles", "none"
"""The axis of the swapped stages, and its first choice: the graph as it is."""
CONDITION, OWN, COMMON = "drive", "own drive", "oracle's drive"
"""The axis of who drives: each variant itself, or the oracle for all of them."""


@dataclass(frozen=True)
class Decomposition:
    """The stages that a study swaps for their oracles, one at a time and cumulatively."""

    oracles: Mapping[str, str]
    """The ``use`` of each stage's oracle, by stage in firing order."""
    has_common_drive: bool
    """Whether all variants are also measured on the drive of one oracle."""

    @property
    def single(self) -> tuple[str, ...]:
        """The variants in which one stage is an oracle."""
        return tuple(self.oracles)

    @property
    def cumulative(self) -> tuple[str, ...]:
        """The variants in which the first stages are oracles, one more each; the first is one of `single`."""
        return tuple(accumulate(self.oracles, "{}+{}".format))

    def stages_of(self, variant: str) -> tuple[str, ...]:
        """Return the stages that are oracles in a variant."""
        return () if variant == BASE else tuple(variant.split("+"))
