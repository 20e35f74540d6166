"""Conditions on the difference of two studies, which make a comparison fail."""

from __future__ import annotations

import math
import operator
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

from graphnav import Place, Problem, UserError, did_you_mean
from graphnav.core.errors import Hint
from graphnav.studies.ablation.results.compare_studies import PairedStudies
from graphnav.studies.ablation.results.comparison import Difference
from graphnav.studies.ablation.study import MetricExpression

HINT = 'write "drive.success < -0.05", or "high(drive.success) < 0" for the upper end of the interval'

_OPERATORS: Mapping[str, Callable[[float, float], bool]] = {
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
}
_BOUNDS = ("mean", "low", "high")
_TEXT = re.compile(r"\s*(.*?)\s*(<=|>=|<|>)\s*(.*?)\s*")
_CALL = re.compile(r"([a-z]+)\s*\(\s*(.*?)\s*\)")


@dataclass(frozen=True)
class FailCondition:
    """``drive.success < -0.05``: on the mean difference of a metric, or a bound of its interval."""

    text: str
    column: MetricExpression
    bound: str
    """"mean", or "low" or "high" for an end of the 95 % interval."""
    operator: str
    limit: float

    @classmethod
    def parse(cls, text: str, place: Place | None = None) -> FailCondition:
        """Read a condition: ``METRIC < NUMBER``, or ``low(METRIC)`` and ``high(METRIC)``; also with ``<= > >=``.

        Raises
        ------
        UserError
            It is something else.
        """
        found = _TEXT.fullmatch(text)
        if found is None:
            raise UserError.of(f"'{text}' has none of < <= > >=", HINT, place)
        left, sign, right = found.groups()
        call = _CALL.fullmatch(left)
        bound, metric = (call[1], call[2]) if call else ("mean", left)
        if bound not in _BOUNDS:
            hint = did_you_mean(bound, _BOUNDS) or f"write one of {', '.join(_BOUNDS)}"
            raise UserError.of(f"'{text}': '{bound}' is not a bound of a difference", hint, place)
        try:
            column = MetricExpression.parse(metric)
        except UserError as error:
            raise UserError.of(f"'{text}': {error.problems[0].what}", HINT, place) from error
        return cls(text.strip(), column, bound, sign, _number(right, text, place))

    def is_met(self, difference: Difference) -> bool:
        """Return whether a difference meets it; an interval that is not known meets nothing."""
        return _OPERATORS[self.operator](float(getattr(difference, self.bound)), self.limit)


@dataclass(frozen=True)
class FailedCase:
    """A case that met a condition, or that could not be judged: ``difference`` is None then."""

    condition: FailCondition
    graph: str
    variant: str
    difference: Difference | None
    is_of_frames: bool = False
    """Whether it could not be judged because the metric is of frames that the two studies do not share."""


def parse_fail_conditions(texts: Sequence[str]) -> tuple[FailCondition, ...]:
    """Return the conditions of ``--fail-if``.

    Raises
    ------
    UserError
        Everything that is wrong with them.
    """
    conditions: list[FailCondition] = []
    problems: list[Problem] = []
    for text in texts:
        try:
            conditions.append(FailCondition.parse(text, Place("--fail-if")))
        except UserError as error:
            problems += error.problems
    if problems:
        raise UserError(problems)
    return tuple(conditions)


def check_fail_conditions(conditions: Sequence[FailCondition], pairing: PairedStudies) -> None:
    """Raise UserError for conditions on metrics that neither study declares."""
    known = list(dict.fromkeys([*pairing.plan_b.declared, *pairing.plan_a.declared]))
    problems = [
        Problem(Place("--fail-if"), f"'{condition.text}': the studies have no metric '{name}'", _near(name, known))
        for condition in conditions
        for name in condition.column.operands
        if name not in known
    ]
    if problems:
        raise UserError(problems)


def failed_cases(conditions: Sequence[FailCondition], pairing: PairedStudies) -> Iterator[FailedCase]:
    """Yield the cases that meet a condition, and those that cannot be judged by it.

    In these no world of both studies has the metric, or it depends on frames that are not the same in both. A case
    that only the first study has cannot be judged either: it is missing from the second.
    """
    for condition in conditions:
        for graph, variant in pairing.only_a:
            yield FailedCase(condition, graph, variant, None)
        for row in pairing.rows:
            difference = row.differences.get(condition.column.text)
            if difference is None or condition.is_met(difference):
                is_of_frames = condition.column.text in row.own_frames
                yield FailedCase(condition, row.graph, row.variant, difference, is_of_frames)


def _near(name: str, known: Sequence[str]) -> Hint:
    return did_you_mean(name, known) or f"they have {', '.join(known)}"


def _number(text: str, condition: str, place: Place | None) -> float:
    try:
        number = float(text)
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        raise UserError.of(f"'{condition}': '{text}' is not a number", HINT, place)
    return number
