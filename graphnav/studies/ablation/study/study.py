"""A study, read: graphs, axes, worlds, metrics."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from itertools import accumulate

from graphnav import Place, UserError
from graphnav.core.graph import Override

_OPERAND = r"[a-z][a-z0-9_]*\.\S+"
_TEXT = re.compile(rf"({_OPERAND})(?: ([-/]) ({_OPERAND}))?")


@dataclass(frozen=True)
class MetricExpression:
    """A column of a table, read: ``a.b``, ``a.b - c.d`` or ``a.b / c.d``, computed run by run.

    So a detector stands relative to itself on true flow: ``sight.auroc / twin_sight.auroc``.
    """

    text: str
    operands: tuple[str, ...]
    """One or two, each ``stage.metric``."""
    operator: str
    """Empty, "-" or "/"."""

    @classmethod
    def parse(cls, text: str) -> MetricExpression:
        """Read a string.

        Raises
        ------
        UserError
            It has none of the three forms.
        """
        found = _TEXT.fullmatch(" ".join(text.split()))
        if found is None:
            raise UserError.of(
                f"'{text}' is not a metric",
                "write stage.metric, or two with ' - ' or ' / ' between, as in 'sight.auroc / twin_sight.auroc'",
            )
        first, operator, second = found.groups()
        return cls(found.group(), (first, second) if operator else (first,), operator or "")

    def renamed(self, name_now: Callable[[str], str]) -> MetricExpression:
        """Return it with other names of its operands."""
        operands = tuple(map(name_now, self.operands))
        return MetricExpression(f" {self.operator} ".join(operands), operands, self.operator)

    def value(self, metric: Callable[[str], float | None]) -> float | None:
        """Return its value, computed from those of its operands; None if one has none or the divisor is 0."""
        values = [found for found in map(metric, self.operands) if found is not None]
        if len(values) < len(self.operands):
            return None
        if self.operator == "-":
            return values[0] - values[1]
        if self.operator == "/":
            ratio = values[0] / values[1] if values[1] else math.nan
            return ratio if math.isfinite(ratio) else None
        return values[0]


AXIS, BASE = "oracles", "none"
"""The axis of the swapped stages, and its first choice: the graph as it is."""
CONDITION, OWN, COMMON = "drive", "own drive", "oracle's drive"
"""The axis of who drives: each variant itself, or the oracle for all of them."""


@dataclass(frozen=True)
class Choice:
    """One value of an axis: its label in tables, and the overrides that make it (none: the graph as it is)."""

    label: str
    overrides: tuple[Override, ...]
    place: Place | None = field(default=None, compare=False)


@dataclass(frozen=True)
class Axis:
    """One thing that varies; the first choice is the base's."""

    name: str
    choices: tuple[Choice, ...]
    place: Place | None = field(default=None, compare=False)


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


@dataclass(frozen=True)
class Study:
    """A study as its file or the command line specifies it."""

    name: str
    about: str
    """The question that it answers."""
    graphs: tuple[str, ...]
    axes: tuple[Axis, ...]
    seeds: tuple[int, ...]
    overrides: tuple[Override, ...] = ()
    """Applied to every run, before those of the axes."""
    metrics: tuple[str, ...] = ()
    """Columns of the table, ``stage.metric``, the one that decides first; empty for all metrics."""
    within: tuple[str, ...] = ()
    """Axes that are conditions: variants are compared with the base within each combination of their choices."""
    one_at_a_time: bool = False
    """Whether each variant differs from the base in one axis; else the axes cross."""
    reference: str = ""
    """The variant whose runs metrics may be relative to; empty for none."""
    worlds: Mapping[str, int] = field(default_factory=dict)
    """By graph: how many of the seeds, the first ones, are its worlds; all of them where it is not named."""
    decomposition: Decomposition | None = None
    """Its stages and their oracles; None where it decomposes nothing."""
    places: dict[str, Place] = field(default_factory=dict, compare=False)
    """The place of each of ``graphs``, ``metrics`` and ``within``, and of the reference."""
