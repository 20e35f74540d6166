"""Figures as studies write them."""

from __future__ import annotations

import pytest

from graphnav.core.errors import UserError
from graphnav.studies.ablation.study.study import MetricExpression

METRICS = {"a.auroc": 0.9, "b.auroc": 0.6, "b.nothing": 0.0}


@pytest.mark.parametrize(
    ("text", "operands", "value"),
    [
        ("a.auroc", ("a.auroc",), 0.9),
        ("a.auroc - b.auroc", ("a.auroc", "b.auroc"), 0.3),
        ("a.auroc / b.auroc", ("a.auroc", "b.auroc"), 1.5),
        ("a.auroc / b.nothing", ("a.auroc", "b.nothing"), None),
        ("a.auroc - b.missing", ("a.auroc", "b.missing"), None),
        ("a.missing", ("a.missing",), None),
    ],
)
def test_values(text: str, operands: tuple[str, ...], value: float | None) -> None:
    metric = MetricExpression.parse(text)
    assert metric.operands == operands
    assert metric.value(METRICS.get) == (value if value is None else pytest.approx(value))


def test_spaces_do_not_count() -> None:
    assert MetricExpression.parse("  a.b   -  c.d ").text == "a.b - c.d"


@pytest.mark.parametrize(
    "text", ["", "auroc", "a.b + c.d", "a.b -", "- a.b", "a.b c.d", "a.b - c.d - e.f", "A.b", "a."]
)
def test_anything_else_is_refused(text: str) -> None:
    with pytest.raises(UserError, match=r"is not a metric\n  write stage.metric"):
        MetricExpression.parse(text)
