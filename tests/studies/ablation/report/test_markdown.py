"""The Markdown tables of a study: rounded, marked, repeatable."""

from __future__ import annotations

import dataclasses
import io
import math
from collections.abc import Callable

import pytest
from hypothesis import given
from hypothesis import strategies as st

from graphnav.core.machine.console import Console
from graphnav.studies.ablation.plan.plan import Plan
from graphnav.studies.ablation.report.html.rendering import MINUS, estimated
from graphnav.studies.ablation.report.legend import seeds_text
from graphnav.studies.ablation.report.markdown import table_markdown
from graphnav.studies.ablation.report.number_format import difference_text, estimate_text
from graphnav.studies.ablation.report.terminal import print_comparison
from graphnav.studies.ablation.results.compare_variants import compare
from graphnav.studies.ablation.results.comparison import Difference, Estimate
from graphnav.studies.ablation.results.records import Record
from graphnav.studies.ablation.results.statistics import Significance
from graphnav.studies.ablation.stopping import pending_runs

MakePlan = Callable[..., Plan]
MakeRecord = Callable[..., Record]


@pytest.mark.parametrize(
    ("mean", "low", "high", "text"),
    [
        (0.9333, 0.9012, 0.9611, "0.933 [0.901, 0.961]"),
        (0.98, 0.8950, 0.9965, "0.980 [0.895, 0.997]"),
        (0.5, 0.1, 0.9, "0.50 [0.10, 0.90]"),
        (1234.5, 1100.0, 1400.0, "1234 [1100, 1400]"),
        (31.415, 29.3, 33.5, "31.4 [29.3, 33.5]"),
        (0.0, 0.0, 0.0, "0.00 [0.00, 0.00]"),
        (0.1, 0.1, 0.1, "0.1000 [0.1000, 0.1000]"),
        (0.1, math.nan, math.nan, "0.1000"),
        (-0.00001, -0.1, 0.1, "0.00 [-0.10, 0.10]"),
        (3e-9, 2e-9, 4e-9, "3.0e-09 [2.0e-09, 4.0e-09]"),
        (0.00002, 0.00001, 0.0003, "2.0e-05 [1.0e-05, 3.0e-04]"),
        (0.00006, 0.00002, 0.0001, "6.0e-05 [2.0e-05, 1.0e-04]"),
        (0.4, 0.001, 30.0, "0.4 [0.0, 30.0]"),
        (0.00002, math.nan, math.nan, "2.0e-05"),
        (0.0, -2e-6, 2e-6, "0.0 [-2.0e-06, 2.0e-06]"),
    ],
)
def test_digits_follow_the_interval(mean: float, low: float, high: float, text: str) -> None:
    assert estimate_text(Estimate(mean, low, high, 50), 50) == text


def test_worlds_without_the_figure_are_told() -> None:
    assert estimate_text(Estimate(0.5, 0.1, 0.9, 12), 50) == "0.50 [0.10, 0.90] (n 12)"


@pytest.mark.parametrize(
    ("mean", "low", "high", "text"),
    [
        (0.02, -0.011, 0.053, "+0.020 [-0.011, +0.053], 7–40–3"),
        (0.0, -0.053, 0.053, "0.000 [-0.053, +0.053], 7–40–3"),
        (-2.0, math.nan, math.nan, "-2.000, 7–40–3"),
        (-0.00003, -0.00005, -0.00001, "-3.0e-05 [-5.0e-05, -1.0e-05], 7–40–3"),
    ],
)
def test_differences_have_a_sign(mean: float, low: float, high: float, text: str) -> None:
    assert difference_text(Difference(mean, low, high, 50, 7, 3)) == text


@pytest.mark.parametrize(
    ("mean", "p_holm", "text"),
    [
        (0.02, 0.0312, "+0.02 [-0.10, +0.10], 7–40–3, p 0.031, smaller than what matters"),
        (0.05, 0.0312, "+0.05 [-0.10, +0.10], 7–40–3, p 0.031"),
        (0.02, 0.312, "+0.02 [-0.10, +0.10], 7–40–3, p 0.31"),
        (0.02, 1.0, "+0.02 [-0.10, +0.10], 7–40–3, p 1"),
        (0.05, 0.00002, "+0.05 [-0.10, +0.10], 7–40–3, p < 0.0001"),
    ],
)
def test_what_decides_has_its_p_value(mean: float, p_holm: float, text: str) -> None:
    found = Difference(mean, -0.1, 0.1, 50, 7, 3, 0.001, 0.05, Significance(p_holm, 17))
    assert difference_text(found) == text


MAGNITUDES = st.floats(-18, 6).map(lambda power: 10.0**power)


@given(MAGNITUDES, st.floats(0, 0.99), st.floats(0, 100), st.sampled_from([-1, 1]))
def test_a_clear_difference_never_reads_as_none(size: float, less: float, more: float, side: int) -> None:
    """It has a digit, and so is at most half of that off."""
    low, high = sorted((side * size * (1 - less), side * size * (1 + more)))
    found = Difference(side * size, low, high, 50, 50, 0, significance=Significance(0.01, 1))
    assert found.is_clear
    for text in (difference_text(found), estimated(found.mean, low, high, signed=True).replace(MINUS, "-")):
        told = text.split(maxsplit=1)[0]
        assert float(told) * side > 0
        assert told.startswith("+-"[side < 0])
        assert float(told) == pytest.approx(found.mean, rel=0.501)


@pytest.mark.parametrize(
    ("seeds", "text"),
    [
        (range(1000, 1050), "1000 to 1049 (50)"),
        ((7,), "7 (1)"),
        ((1, 5, 7), "1, 5, 7 (3)"),
        ((3, 2, 1, 0, 9, 8), "0 to 3, 8, 9 (6)"),
    ],
)
def test_seeds_in_short(seeds: tuple[int, ...], text: str) -> None:
    assert seeds_text(seeds) == text


@pytest.fixture
def study(make_plan: MakePlan, make_record: MakeRecord) -> tuple[Plan, list[Record]]:
    metrics = {"drive.success": "higher", "drive.time_s": "lower", "a.x / b.x": "higher", "a.x": "higher"}
    plan = make_plan(
        variants=("ica", "affine", "twin", "random"), seeds=range(20), metrics=metrics, same_as={"twin": "affine"}
    )
    cases = tuple(
        dataclasses.replace(case, role="baseline") if case.variant == "random" else case for case in plan.cases
    )
    records = [
        make_record(variant, seed, {"drive.success": float(seed > shift), "drive.time_s": 30.0 + shift + 0.125 * seed})
        for variant, shift in (("ica", 0), ("affine", 1), ("twin", 1))
        for seed in range(20)
    ]
    broken = make_record("random", 0, outcome="failed", cause="stage 'plane' failed: a|b\nworse")
    return dataclasses.replace(plan, cases=cases), [*records, broken]


def test_table_has_everything_it_takes(study: tuple[Plan, list[Record]]) -> None:
    plan, records = study
    text = table_markdown(plan, compare(plan, records, pending_runs(plan, records)))
    for line in (
        "# toy",
        "Which one?",
        "## corridor",
        "| variant | worlds | outcomes | drive.success ↑ | difference | drive.time_s ↓ | difference | a.x / b.x ↑ |",
        "| ica (base) | 20 | goal 20 | 0.95 [0.76, 0.99] |",
        "| affine | 20 |",
        "| +1.000 [+1.000, +1.000], 0–0–20 |",
        "- affine is the same graph as twin",
        "| random (baseline) | 1 of 20 | failed 1 | 0.00 [0.00, 0.79] |",
        "| variant | a.x ↑ | difference |",
        "- random, 1: stage 'plane' failed: a\\|b worse",
        "| -0.05 [-0.20, +0.11], 0–19–1, p 1 |",
        "Student's t",
        "drive.success decides: its differences are bold where p is at most 0.05",
        "the mean is at least 0.05, the smallest difference that matters",
        "A baseline is what",
        "- command: `graphnav ablate toy --seeds 0:3`",
        "- seeds: `0 to 19 (20)`",
        "- versions: `graphnav 0.1.0`",
    ):
        assert line in text, line
    tables = [block for block in text.split("\n\n") if block.startswith("| variant")]
    for table in tables:
        assert len({line.replace("\\|", "").count("|") for line in table.splitlines()}) == 1, (
            "every row has every column"
        )


def test_only_what_decides_is_bold_and_where_it_matters(study: tuple[Plan, list[Record]]) -> None:
    plan, records = study
    time = dataclasses.replace(plan, metrics=("drive.time_s",))
    assert "| **+1.000 [+1.000, +1.000], 0–0–20, p < 0.0001** |" in table_markdown(time, compare(time, records))
    metric = dataclasses.replace(plan.metric("drive.time_s"), min_difference=1.5)
    large = dataclasses.replace(time, declared={**plan.declared, "drive.time_s": metric})
    text = table_markdown(large, compare(large, records))
    assert "| +1.000 [+1.000, +1.000], 0–0–20, p < 0.0001, smaller than what matters |" in text


def test_too_few_worlds_are_said_to_be_too_few(make_plan: MakePlan, make_record: MakeRecord) -> None:
    plan = make_plan(variants=[f"v{k}" for k in range(18)], seeds=range(6), metrics={"a.x": "higher"})
    records = [
        make_record(case.variant, seed, {"a.x": seed + 10.0 * place})
        for place, case in enumerate(plan.cases)
        for seed in plan.seeds
    ]
    comparison = compare(plan, records)
    said = "6 worlds cannot separate 17 variants from the base, even if all speak for one side: that takes 10."
    out = io.StringIO()
    print_comparison(Console(file=out, width=200), comparison, plan)
    assert said in table_markdown(plan, comparison)
    assert said in out.getvalue()
    assert "**" not in table_markdown(plan, comparison)


def test_a_study_without_metrics_of_its_own_shows_all(make_plan: MakePlan, make_record: MakeRecord) -> None:
    plan = make_plan(lower=("c.z",))
    text = table_markdown(plan, compare(plan, [make_record("ica", 0, {"a.x": 1.0, "b.y": 2.0, "c.z": 0.5})]))
    assert all(name in text for name in ("a.x ↑", "b.y ↑", "c.z ↓"))
    assert "| variant | worlds | outcomes |" in table_markdown(plan, compare(plan, []))


@pytest.mark.parametrize("width", [20, 80, 300])
def test_terminal_shows_whole_numbers_however_narrow_it_is(study: tuple[Plan, list[Record]], width: int) -> None:
    plan, records = study
    out = io.StringIO()
    print_comparison(Console(file=out, width=width), compare(plan, records), plan)
    for text in ("0.95 [0.76, 0.99]", "+1.000 [+1.000, +1.000], 0–0–20", "drive.time_s ↓", "failed: a|b"):
        assert text in out.getvalue()
    assert "a.x" not in out.getvalue(), "only the metrics that decide"


def test_a_terminal_that_is_too_narrow_gets_a_table_for_each_metric(study: tuple[Plan, list[Record]]) -> None:
    plan, records = study
    out = io.StringIO()
    print_comparison(Console(file=out, width=80, force_terminal=True, color_system=None), compare(plan, records), plan)
    assert max(map(len, out.getvalue().splitlines())) <= 80
    for text in ("0.95 [0.76, 0.99]", "+1.000 [+1.000, +1.000], 0–0–20", "drive.time_s ↓", "failed: a|b"):
        assert text in out.getvalue()


def test_terminal_colours_what_is_sure(study: tuple[Plan, list[Record]]) -> None:
    plan, records = study
    plan = dataclasses.replace(plan, metrics=("drive.time_s", "drive.success"))
    out = io.StringIO()
    print_comparison(
        Console(file=out, width=200, force_terminal=True, color_system="standard"), compare(plan, records), plan
    )
    assert "\x1b[31m+1.000" in out.getvalue(), "longer is worse"
    assert "\x1b[32m" not in out.getvalue()
