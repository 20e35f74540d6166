"""Ranges of parameters for which a study names none."""

from __future__ import annotations

import pytest

from graphnav import Stage, param
from graphnav.core.stage.param import params_of
from graphnav.studies.tuning.search_range import range_of


class Bounded(Stage):
    """Has numbers with bounds of all kinds."""

    above: float = param(4.0, gt=0.0, le=1e3, doc="dimensionless")
    between: float = param(0.5, gt=0.25, lt=0.6, doc="dimensionless")
    share: float = param(0.0, ge=0.0, lt=1.0, doc="dimensionless")
    open_end: float = param(0.0, ge=0.0, doc="dimensionless")
    count: int = param(4, ge=3, le=1000, doc="dimensionless")


@pytest.mark.parametrize(
    ("name", "low", "high"),
    [("above", 1.0, 16.0), ("between", 0.25025, 0.59965), ("share", 0.0, 0.999), ("count", 3, 16)],
)
def test_a_number_is_searched_around_its_value_within_its_bounds(name: str, low: float, high: float) -> None:
    found = range_of(f"stage.{name}", params_of(Bounded)[name], params_of(Bounded)[name].default)
    assert found is not None
    assert (found.low, found.high) == pytest.approx((low, high))


def test_without_two_bounds_zero_has_no_range() -> None:
    assert range_of("stage.open_end", params_of(Bounded)["open_end"], 0.0) is None
