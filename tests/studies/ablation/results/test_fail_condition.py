"""Conditions on differences: what they mean, and what is refused."""

from __future__ import annotations

import math

import pytest

from graphnav.core.errors import UserError
from graphnav.studies.ablation.results.comparison import Difference
from graphnav.studies.ablation.results.fail_condition import FailCondition, parse_fail_conditions

WORSE = Difference(mean=-0.1, low=-0.2, high=0.02, n=20, won=1, lost=3)


@pytest.mark.parametrize(
    ("text", "met"),
    [
        ("drive.success < -0.05", True),
        ("drive.success<-0.1", False),
        ("mean(drive.success) <= -0.1", True),
        ("drive.success > -1e-1", False),
        ("drive.success >= -0.1", True),
        ("high(drive.success) < 0", False),
        ("low( drive.success ) < -0.15", True),
        ("drive.success / drive.spl < 0", True),
    ],
)
def test_it_compares_the_mean_or_an_end_of_the_interval(text: str, met: bool) -> None:
    assert FailCondition.parse(text).is_met(WORSE) is met


@pytest.mark.parametrize("bound", ["low", "high"])
def test_an_unknown_interval_meets_nothing(bound: str) -> None:
    single = Difference(mean=-1.0, low=math.nan, high=math.nan, n=1, won=0, lost=1)
    assert not any(FailCondition.parse(f"{bound}(a.b) {sign} 0").is_met(single) for sign in ("<", "<=", ">", ">="))


def test_everything_that_is_wrong_is_said() -> None:
    texts = ["drive.success", "success < 0", "drive.success < worse", "hihg(a.b) < 0", "a.b < nan", "a.b < 0"]
    with pytest.raises(UserError) as error:
        parse_fail_conditions(texts)
    hint = 'write "drive.success < -0.05", or "high(drive.success) < 0" for the upper end of the interval'
    assert [(problem.what, str(problem.hint)) for problem in error.value.problems] == [
        ("'drive.success' has none of < <= > >=", hint),
        ("'success < 0': 'success' is not a metric", hint),
        ("'drive.success < worse': 'worse' is not a number", hint),
        ("'hihg(a.b) < 0': 'hihg' is not a bound of a difference", "did you mean 'high'?"),
        ("'a.b < nan': 'nan' is not a number", hint),
    ]
    assert {str(problem.place) for problem in error.value.problems} == {"--fail-if"}
