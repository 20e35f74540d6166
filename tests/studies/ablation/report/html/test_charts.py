"""Axes show what they must, lines are drawn where an axis is one of numbers."""

from __future__ import annotations

import math
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from graphnav.core.stage import Better, Role
from graphnav.studies.ablation.report.html.charts.scale import scale_of, wide_scale_of
from graphnav.studies.ablation.report.html.plots import axis_numbers
from graphnav.studies.ablation.report.html.rendering import MINUS, estimated, means_text, number
from graphnav.studies.ablation.report.html.study_results import Verdict, verdict_of
from graphnav.studies.ablation.results.comparison import Difference, Row
from graphnav.studies.ablation.results.statistics import Significance

from .example_study import Page, plan_of, record_of, records_of, report

NUMBERS = st.floats(-1e6, 1e6, allow_subnormal=False)


@settings(deadline=None)
@given(st.lists(NUMBERS, max_size=8), st.integers(2, 8))
def test_an_axis_shows_all_values_between_even_ticks(values: list[float], max_steps: int) -> None:
    scale = scale_of([*values, math.nan, math.inf], max_steps)
    steps = [b - a for a, b in zip(scale.ticks, scale.ticks[1:], strict=False)]
    slack = 1e-3 * steps[0]
    assert all(scale.low - slack <= value <= scale.high + slack for value in values)
    assert steps == pytest.approx([steps[0]] * len(steps))
    assert 2 <= len(scale.ticks) <= max_steps + 3


def test_shares_have_the_axis_from_0_to_1() -> None:
    scale = scale_of([-1e-12, 0.3, 0.9])
    assert (scale.low, scale.high) == (0.0, 1.0)


def test_places_are_linear_and_end_at_the_ends() -> None:
    scale = scale_of([0.0, 1.0]).between(100.0, 200.0)
    assert [scale.at(x) for x in (-1.0, 0.0, 0.25, 1.0, 7.0)] == [100.0, 100.0, 125.0, 200.0, 200.0]


def test_an_axis_is_logarithmic_where_values_differ_a_hundredfold() -> None:
    assert not wide_scale_of([0.1, 9.9]).is_log
    assert not wide_scale_of([0.001, 0.99]).is_log
    assert not wide_scale_of([-1.0, 0.01, 10.0]).is_log
    scale = wide_scale_of([0.0, 0.031, math.nan, 10.4]).between(0.0, 300.0)
    assert scale.ticks == pytest.approx((0.03, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0))
    assert [scale.label(tick) for tick in scale.ticks] == ["≤0.03", "0.1", "0.3", "1", "3", "10", "30"]
    assert [scale.at(value) for value in (0.0, 0.03, 0.3, 30.0)] == pytest.approx([0.0, 0.0, 100.0, 300.0])


def test_numbers_are_as_exact_as_their_intervals() -> None:
    assert estimated(0.943, 0.84, 0.981) == "0.943 [0.840, 0.981]"
    assert estimated(-0.0412, -0.12, 0.023, signed=True) == f"{MINUS}0.041 [{MINUS}0.120, 0.023]"
    assert estimated(12.0, math.nan, math.nan, signed=True) == "+12.00"
    assert estimated(-0.00002, -0.0003, -0.00001) == "-2.0e-05 [-3.0e-04, -1.0e-05]".replace("-", MINUS)
    assert number(-0.0001, ".2f") == "0.00"
    assert means_text([0.9, 0.02, 0.5]) == "0.02 to 0.90"
    assert means_text([0.0, 0.0]) == "0.00"
    assert means_text([0.0, 0.00002]) == f"0.0 to 2.0e{MINUS}05"
    assert means_text([-0.004, 0.001], signed=True) == f"{MINUS}0.004 to +0.001"


@pytest.mark.parametrize(
    ("labels", "places"),
    [
        (("robot.tilt_deg=75", "robot.tilt_deg=20", "robot.tilt_deg=35"), (75, 20, 35)),
        (("0.3 m/s", "0.15 m/s", "1.2 m/s"), (0.3, 0.15, 1.2)),
        (("75°", "20°", "-5°"), (75, 20, -5)),
        (("1e-3", "1e-2", "0.5"), (0.001, 0.01, 0.5)),
        (("plane.ica", "plane.affine", "plane.truth"), None),
        (("0.1", "0.2"), None),
        (("0.1", "0.2", "off"), None),
        (("1 of 2", "2 of 2", "2 of 3"), None),
        (("7", "7.0", "7.00"), None),
    ],
)
def test_an_axis_is_one_of_numbers_if_every_label_has_one(
    labels: tuple[str, ...], places: tuple[float, ...] | None
) -> None:
    assert axis_numbers(labels) == (None if places is None else dict(zip(labels, places, strict=True)))


def test_a_line_is_drawn_for_every_stage_that_has_the_figure(tmp_path: Path) -> None:
    tilts: dict[str, Role] = dict.fromkeys(("75°", "20°", "50°"), "method")
    metrics = ("ica_sight.auroc", "affine_sight.auroc")
    plan = plan_of(tilts, metrics=metrics, axis="tilt", seeds=range(6))
    records = [
        record_of(case, seed, "goal", ica_sight__auroc=0.9 - seed / 100, affine_sight__auroc=0.7)
        for case in plan.cases
        for seed in plan.seeds
    ]
    text = report(plan, records, tmp_path)
    Page(text)
    first_screen = text[text.index("<header>") : text.index("</header>")]
    assert first_screen.count('class="line"') == 2
    for name in ("ica_sight", "affine_sight"):
        assert f"</title>{name}</text>" in first_screen


def test_a_crossed_axis_has_a_line_for_each_choice_of_the_other(tmp_path: Path) -> None:
    speeds: dict[str, Role] = dict.fromkeys(("1", "2", "3"), "method")
    plan = plan_of(speeds, axis="speed", seeds=range(6))
    text = report(plan, records_of(plan, {"1": 0.9, "2": 0.5, "3": 0.1}), tmp_path)
    assert text.count('class="line"') == 2


@pytest.mark.parametrize(
    ("low", "high", "n", "better", "expected"),
    [
        (0.1, 0.3, 20, "higher", "better"),
        (0.1, 0.3, 20, "lower", "worse"),
        (-0.3, -0.1, 20, "higher", "worse"),
        (-0.3, -0.1, 20, "lower", "better"),
        (-0.1, 0.3, 20, "higher", "unclear"),
        (0.0, 0.3, 20, "higher", "unclear"),
        (0.1, 0.3, 2, "higher", "unknown"),
        (math.nan, math.nan, 1, "higher", "unknown"),
    ],
)
def test_only_a_clear_difference_is_called_one(
    low: float, high: float, n: int, better: Better, expected: Verdict
) -> None:
    case = plan_of({"ica": "method", "affine": "method"}).cases[1]
    mean = 0.0 if math.isnan(low) else (low + high) / 2
    found = Difference(mean, low, high, n, 0, 0, significance=Significance(0.04, 1))
    row = Row(case, n, {}, {}, {}, {"drive.spl": found}, {})
    assert verdict_of(row, "drive.spl", better) == expected


@pytest.mark.parametrize(
    ("significance", "min_difference", "expected"),
    [
        (Significance(0.05, 17), 0.2, "better"),
        (Significance(0.051, 17), 0.2, "unclear"),
        (Significance(0.05, 17), 0.201, "small"),
        (Significance(0.051, 17), 0.201, "unclear"),
        (Significance(0.05, 2**20), 0.0, "unknown"),
        (None, 0.0, "untested"),
    ],
)
def test_a_difference_counts_in_its_family_and_where_it_matters(
    significance: Significance | None, min_difference: float, expected: Verdict
) -> None:
    case = plan_of({"ica": "method", "affine": "method"}).cases[1]
    found = Difference(0.2, 0.1, 0.3, 20, 15, 0, 0.001, min_difference, significance)
    row = Row(case, 20, {}, {}, {}, {"drive.spl": found}, {})
    assert verdict_of(row, "drive.spl", "higher") == expected
