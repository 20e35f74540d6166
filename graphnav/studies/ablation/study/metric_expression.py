"""A metric as a study names it: ``stage.metric``, or the difference or ratio of two."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import dataclass

from graphnav.core.errors import UserError

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
