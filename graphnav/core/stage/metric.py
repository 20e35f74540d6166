"""Metrics of stages: the numbers that a stage reports of a run, declared with unit, direction and help."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping
from dataclasses import KW_ONLY, dataclass
from functools import cache
from types import MappingProxyType
from typing import Any, Final, Literal, get_args

from graphnav.core.errors import DeclarationError
from graphnav.core.stage.former_names import FormerNames
from graphnav.core.stage.units import unit_of

Better = Literal["higher", "lower", "neither"]
"""Which values of a metric are better; neither of a count, or of what only describes a run."""

MEASURED: Final = "measured"
"""Of `Metric.if_failed`: a failed drive counts with what was measured, as an error or a clearance does."""
UNDEFINED: Final = "undefined"
"""Of `Metric.if_failed`: reported only of drives that arrive, as path length and duration are."""


@dataclass(frozen=True)
class Metric:
    """The declaration of a metric.

    Parameters
    ----------
    name
        In `Stage.summary` and, behind the stage's, in tables: an identifier. It ends in the suffix of its unit
        (``_m``, ``_ratio``) where graphnav has one.
    help
        One sentence: what is measured, over what, and when it is left out.
    better
        Which values are better.
    unit
        As tables show it: ``"m"``, ``"m/s³"``, ``"ratio"``; empty for counts and for what is 0 or 1.
    if_failed
        The value that a drive counts with if it did not arrive or if a stage failed; `UNDEFINED`: reported only of
        drives that arrive; `MEASURED`: reported of all drives, and not compared where a stage failed.
    is_outcome
        Whether it is 1 for a drive that arrived and 0 for one that did not. Counts as 0 if a stage failed.
    min_difference
        The smallest difference between two means that matters, in the metric's unit; 0: any. Studies call no smaller
        difference clear.
    of_frames
        Whether it depends on which frames a run meets, as the score of a detector does. Variants of a study that drive
        differently meet different frames: then it is reported of each, and not compared.
    is_key
        Whether it is one of the few that sum up a run: those ``graphnav ablate --decompose`` shows by default.
    relative_to
        Another metric of the stage, one that is better lower and above 0. The stage does not report this one: a study
        that names a reference variant adds it to each run that has the other, as ``reference / max(own, reference)``
        where ``reference`` is the other in the reference's run in the same world. It is ``if_failed`` where the drive
        did not arrive or a stage failed, and missing where the reference's run does not have the other.
    bounds
        The lowest and the highest value that is possible; None in place of one of them: no bound on that side, as
        (0, None) of a length. Intervals of means end there. None: unknown. An outcome has (0, 1). Studies that are
        stopped by their results (``--until-clear``) need both.
    """

    name: str
    _: KW_ONLY
    help: str
    better: Better
    unit: str = ""
    if_failed: float | Literal["measured", "undefined"] = MEASURED
    is_outcome: bool = False
    min_difference: float = 0.0
    of_frames: bool = False
    is_key: bool = False
    relative_to: str = ""
    bounds: tuple[float | None, float | None] | None = None

    @property
    def span(self) -> tuple[float, float] | None:
        """The lowest and the highest possible value, infinite where there is no bound; None: unknown."""
        if self.is_outcome:
            return 0.0, 1.0
        if self.bounds is None:
            return None
        low, high = self.bounds
        return -math.inf if low is None else low, math.inf if high is None else high

    @property
    def limits(self) -> tuple[float, float] | None:
        """The lowest and the highest possible value, both finite; None where one is not."""
        return self.span if self.span is not None and all(map(math.isfinite, self.span)) else None

    @property
    def label(self) -> str:
        """The name, and the unit where the name does not tell it."""
        return f"{self.name} [{self.unit}]" if self.unit and unit_of(self.name).symbol != self.unit else self.name


def metrics_of(cls: type) -> Mapping[str, Metric]:
    """Return the declared metrics of a stage class by name, in order.

    Raises
    ------
    DeclarationError
        What is declared is not a list of metrics with names, directions and help.
    """
    return _metrics_of(cls)


@cache
def _metrics_of(cls: Any) -> Mapping[str, Metric]:
    for former, now in FormerNames.STAGE_ATTRIBUTES.items():
        if hasattr(cls, former):
            raise DeclarationError(f"{cls.__qualname__} has '{former}': declare '{now}' = (Metric(...), ...)")
    declared = cls.metrics
    if not isinstance(declared, tuple) or not all(isinstance(metric, Metric) for metric in declared):
        raise DeclarationError(f"the metrics of {cls.__qualname__} are not a tuple: write (Metric(...), ...)")
    repeated = [name for name, times in Counter(metric.name for metric in declared).items() if times > 1]
    if repeated:
        raise DeclarationError(f"{cls.__qualname__} declares the metric '{repeated[0]}' twice: keep one")
    for metric in declared:
        if fault := _fault(metric) or _relative_fault(metric, declared):
            raise DeclarationError(f"metric '{metric.name}' of {cls.__qualname__}: {fault}")
    return MappingProxyType({metric.name: metric for metric in declared})


def _relative_fault(metric: Metric, declared: tuple[Metric, ...]) -> str:
    """Return what is wrong with what a metric is relative to, empty if nothing is."""
    if not metric.relative_to:
        return ""
    other = next((other for other in declared if other.name == metric.relative_to), None)
    if other is None or other.relative_to:
        return f"relative_to is '{metric.relative_to}': name a metric that the stage reports"
    if other.better != "lower" or metric.better != "higher":
        return f"relative_to is '{other.name}': of the other lower has to be better, of this one higher"
    return "if_failed is 'undefined': use a number, or MEASURED" if metric.if_failed == UNDEFINED else ""


def _fault(metric: Metric) -> str:
    """Return what is wrong with a metric and what to do, empty if nothing is."""
    if not metric.name.isidentifier():
        return "the name is not an identifier: use letters, digits and _"
    if not metric.help.strip():
        return "it has no help: write a sentence"
    if not isinstance(metric.unit, str):
        return f"unit is {metric.unit!r}: use a string"
    if (named := unit_of(metric.name).symbol) and named != metric.unit:
        return f"unit is '{metric.unit}', but the name says '{named}': change one of them"
    if metric.better not in get_args(Better):
        return f"better is {metric.better!r}: use {', '.join(get_args(Better))}"
    return _value_fault(metric)


def _value_fault(metric: Metric) -> str:
    if isinstance(metric.if_failed, str) and metric.if_failed not in {MEASURED, UNDEFINED}:
        return f"if_failed is {metric.if_failed!r}: use a number, UNDEFINED or MEASURED"
    if not isinstance(metric.if_failed, str) and not _is_number(metric.if_failed):
        return f"if_failed is {metric.if_failed!r}: use a number, UNDEFINED or MEASURED"
    if metric.is_outcome and metric.if_failed != 0.0:
        return "an outcome is 0 of a failed drive: write if_failed=0.0"
    if not (isinstance(metric.min_difference, float | int) and 0 <= metric.min_difference < math.inf):
        return f"min_difference is {metric.min_difference!r}: use a number of 0 or more"
    return _bounds_fault(metric)


def _is_number(value: object) -> bool:
    return isinstance(value, float | int) and not isinstance(value, bool) and math.isfinite(value)


def _bounds_fault(metric: Metric) -> str:
    """Return what is wrong with the bounds of a metric, empty if nothing is."""
    if metric.bounds is None:
        return ""
    bounds: Any = metric.bounds
    is_pair = isinstance(bounds, tuple) and len(bounds) == 2
    if not is_pair or not all(bound is None or _is_number(bound) for bound in bounds):
        return f"bounds are {bounds!r}: write the lowest and the highest value, as (0, 1) or (0, None)"
    if bounds == (None, None) or (None not in bounds and not bounds[0] < bounds[1]):
        return f"bounds are {bounds!r}: write the lowest and the highest value, as (0, 1) or (0, None)"
    return "" if not metric.is_outcome or bounds == (0, 1) else f"bounds are {bounds!r}, but an outcome is 0 or 1"
