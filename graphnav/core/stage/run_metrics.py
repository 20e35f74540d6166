"""The metrics that a stage reports of a run: its summary, read by its declaration."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Any, SupportsFloat

from graphnav.core.errors import DeclarationError, shown_value
from graphnav.core.stage.metric import MEASURED, UNDEFINED, metrics_of
from graphnav.core.stage.stage import Stage


def measured_metrics(stage: Stage) -> dict[str, float]:
    """Return what a stage has measured of a run so far, by name, whatever will become of the drive.

    Raises
    ------
    DeclarationError
        As `reported_metrics`.
    """
    return _values(stage, metrics_of(type(stage)))


def reported_metrics(stage: Stage) -> dict[str, float]:
    """Return the metrics of a stage after a run, by name; one that is not defined for this run is missing.

    For a drive that did not arrive, which an outcome of the stage tells, each metric is what its declaration says of
    failed drives.

    Raises
    ------
    DeclarationError
        The summary is not a mapping, or holds a metric that the stage does not declare or that is not a number.
    """
    declared = metrics_of(type(stage))
    values = _values(stage, declared)
    has_arrived = all(value != 0.0 for name, value in values.items() if declared[name].is_outcome)
    if has_arrived:
        return values
    counted = {name: (declared[name].if_failed, value) for name, value in values.items()}
    return {
        name: value if if_failed == MEASURED else float(if_failed)
        for name, (if_failed, value) in counted.items()
        if if_failed != UNDEFINED
    }


def _values(stage: Stage, declared: Collection[str]) -> dict[str, float]:
    """Return what a stage's summary holds, as floats."""
    summary: Any = stage.summary()
    what = f"summary() of {type(stage).__qualname__}"
    if not isinstance(summary, Mapping):
        raise DeclarationError(f"{what} returns {type(summary).__name__}: return a mapping of metrics by name")
    values: dict[str, float] = {}
    for name, value in summary.items():
        if not isinstance(name, str):
            raise DeclarationError(f"{what} has the key {shown_value(name)}: name each metric by a string")
        if name not in declared:
            shown = shown_value(name)
            raise DeclarationError(f"{what} returns {shown}, which it does not declare: add Metric({shown}, ...)")
        if not isinstance(value, SupportsFloat):
            raise DeclarationError(f"{what} gives '{name}' as {shown_value(value)}: give a number, or leave it out")
        values[name] = float(value)
    return values
