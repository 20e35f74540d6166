"""Plans of version 0.1.0, whose stages declared no metrics."""

from __future__ import annotations

from typing import Any

from graphnav import Metric
from graphnav.core.stage import FormerNames, unit_of
from graphnav.studies.ablation.study import MetricExpression


def as_written_now(data: dict[str, Any]) -> dict[str, Any]:
    """Return what ``plan.json`` holds, one of version 0.1.0 as this version would write it.

    Raises
    ------
    KeyError, TypeError, AttributeError
        It is not a plan.
    """
    if "metrics" in data:
        return data
    now = dict(data)
    columns = [MetricExpression.parse(text).renamed(FormerNames.metric_now) for text in now.pop("figures")]
    lower = [FormerNames.metric_now(name) for name in now.pop("less_is_better")]
    stages = dict.fromkeys(stage for case in data["cases"] for stage in case["uses"])
    operands = [name for column in columns for name in column.operands]
    zero = [f"{stage}.{name}" for stage in stages for name in FormerNames.ZERO_IF_FAILED]
    names = dict.fromkeys([*operands, *lower, *zero])
    now["metrics"] = [column.text for column in columns]
    now["declared"] = {name: vars(_metric(name, is_lower=name in lower)) for name in names}
    now["cases"] = [_case(case) for case in data["cases"]]
    return now


def undeclared(name: str) -> Metric:
    """Return what is known of a metric that runs of version 0.1.0 report and its plan does not name."""
    metric = name.partition(".")[2]
    return Metric(metric, help="", unit=unit_of(metric).symbol, better="higher")


def _metric(name: str, *, is_lower: bool) -> Metric:
    metric = name.partition(".")[2]
    is_outcome = metric == FormerNames.OUTCOME
    return Metric(
        metric,
        help="",
        unit=unit_of(metric).symbol,
        better="lower" if is_lower else "higher",
        if_failed=0.0 if metric in FormerNames.ZERO_IF_FAILED else "measured",
        is_outcome=is_outcome,
    )


def _case(case: dict[str, Any]) -> dict[str, Any]:
    role = FormerNames.ROLES.get(case["role"], case["role"])
    return {**case, "role": role}
