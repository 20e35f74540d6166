"""Metrics: what a stage declares, and what it reports of a drive that did not arrive."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, ClassVar

import pytest
from hypothesis import given
from hypothesis import strategies as st

from graphnav import MEASURED, UNDEFINED, Metric, Stage, Twist
from graphnav.core.errors import DeclarationError
from graphnav.core.stage import metrics_of, reported_metrics


class Drive(Stage):
    """Reports whatever it is given."""

    metrics: ClassVar[tuple[Metric, ...]] = (
        Metric("arrived", better="higher", if_failed=0.0, is_outcome=True, help="Whether it arrived."),
        Metric("path_m", unit="m", better="lower", if_failed=UNDEFINED, help="Length."),
        Metric("share", better="higher", if_failed=-1.0, help="Share."),
        Metric("error_m", unit="m", better="lower", help="Error."),
    )
    values: ClassVar[Mapping[str, float]] = {}

    def step(self, twist: Twist) -> None:
        pass

    def summary(self) -> Mapping[str, float]:
        return self.values


NAMES = list(metrics_of(Drive))
VALUES = st.dictionaries(st.sampled_from(NAMES[1:]), st.floats(allow_nan=False))


def reported(values: Mapping[str, float]) -> dict[str, float]:
    """Return what a stage reports whose summary is ``values``."""
    cls: Any = type("Given", (Drive,), {"values": values, "__doc__": "Reports."})
    return reported_metrics(cls())


@given(VALUES)
def test_a_drive_that_arrived_reports_what_was_measured(values: dict[str, float]) -> None:
    assert reported(values) == values, "without an outcome, too"
    assert reported({"arrived": 1.0, **values}) == {"arrived": 1.0, **values}


@given(VALUES)
def test_a_drive_that_did_not_arrive_reports_what_is_declared(values: dict[str, float]) -> None:
    found = reported({"arrived": 0.0, **values})
    assert found.keys() == {"arrived", *values} - {"path_m"}
    assert found["arrived"] == 0.0
    assert found.get("share", -1.0) == -1.0
    assert found.get("error_m") == values.get("error_m")


@pytest.mark.parametrize(
    ("values", "what"),
    [
        (None, "returns NoneType: return a mapping of metrics by name"),
        (["share"], "returns list: return a mapping of metrics by name"),
        ({"share": None}, "gives 'share' as None: give a number, or leave it out"),
        ({"share": "0.5"}, "gives 'share' as '0.5': give a number, or leave it out"),
    ],
)
def test_a_summary_that_is_not_metrics_is_refused(values: Any, what: str) -> None:
    with pytest.raises(DeclarationError) as caught:
        reported(values)
    assert str(caught.value) == f"summary() of Given {what}"


def test_a_unit_that_contradicts_the_name_is_refused() -> None:
    declared = (Metric("path_m", unit="s", better="lower", help="Length."),)
    cls: Any = type("Given", (Drive,), {"metrics": declared, "__doc__": "Reports."})
    with pytest.raises(DeclarationError, match="'path_m' of Given: unit is 's', but the name says 'm': change one"):
        metrics_of(cls)


def test_a_metric_that_is_not_declared_is_refused() -> None:
    with pytest.raises(DeclarationError, match=r"'depth_m', which it does not declare: add Metric\('depth_m', "):
        reported({"depth_m": 1.0})


@pytest.mark.parametrize(
    ("metrics", "said"),
    [
        ([Metric("x", better="higher", help="X.")], "not a tuple"),
        (("x",), "not a tuple"),
        ((Metric("x", better="higher", help="X."),) * 2, "'x' twice: keep one"),
        ((Metric("two words", better="higher", help="X."),), "the name is not an identifier"),
        ((Metric("x", better="higher", help=" "),), "it has no help"),
        ((Metric("x", better="more", help="X."),), "better is 'more': use higher, lower, neither"),  # type: ignore[arg-type]
        ((Metric("x", better="lower", help="X.", if_failed="nothing"),), "if_failed is 'nothing'"),  # type: ignore[arg-type]
        ((Metric("x", better="lower", help="X.", if_failed=None),), "if_failed is None"),  # type: ignore[arg-type]
        ((Metric("x", better="lower", help="X.", if_failed=float("nan")),), "if_failed is nan"),
        ((Metric("x", better="higher", help="X.", is_outcome=True),), "an outcome is 0 of a failed drive"),
        ((Metric("x", better="higher", help="X.", min_difference=-0.1),), "min_difference is -0.1: use a number of 0"),
        ((Metric("x", better="higher", help="X.", min_difference=math.inf),), "min_difference is inf"),
        ((Metric("x", better="higher", help="X.", bounds=(1, 0)),), r"bounds are \(1, 0\): write the lowest"),
        ((Metric("x", better="higher", help="X.", bounds=(None, None)),), r"bounds are \(None, None\): write the"),
        ((Metric("x", better="higher", help="X.", bounds=(0, math.inf)),), r"bounds are \(0, inf\): .* or \(0, None\)"),
        ((Metric("x", better="higher", help="X.", relative_to="y"),), "relative_to is 'y': name a metric that the"),
        (
            (
                Metric("x", better="higher", help="X.", relative_to="y"),
                Metric("y", better="higher", help="Y."),
            ),
            "relative_to is 'y': of the other lower has to be better",
        ),
    ],
)
def test_what_is_wrong_with_a_declaration_is_said(metrics: Any, said: str) -> None:
    with pytest.raises(DeclarationError, match=said):
        metrics_of(type("Wrong", (Drive,), {"metrics": metrics}))


def test_a_declaration_of_version_0_1_0_is_refused() -> None:
    with pytest.raises(DeclarationError, match="'less_is_better': declare 'metrics'"):
        metrics_of(type("Former", (Drive,), {"less_is_better": frozenset({"x"})}))


def test_a_label_has_the_unit_once() -> None:
    labels = [
        Metric(name, better="lower", unit=unit, help="X.", if_failed=MEASURED).label
        for name, unit in (("path_m", "m"), ("power", "W"), ("share_ratio", "ratio"), ("frames", ""), ("m", "m"))
    ]
    assert labels == ["path_m", "power [W]", "share_ratio", "frames", "m [m]"]
