"""All pairs of variants, performance profiles, and parallel coordinates."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import pytest

from graphnav.core.stage import Metric, Role
from graphnav.studies.ablation.plan.plan import Plan
from graphnav.studies.ablation.report.html.charts import Steps, Strand, parallel_chart, profile_chart
from graphnav.studies.ablation.results.records import Record

from .example_study import SUCCESS, Page, plan_of, record_of, records_of, report

NUMBER = r"-?\d+(?:\.\d+)?"


def methods(*variants: str) -> dict[str, Role]:
    return dict.fromkeys(variants, "method")


def points(curve: str) -> list[tuple[float, float]]:
    """Return the corners of a path of absolute coordinates."""
    return [(float(x), float(y)) for x, y in re.findall(rf"({NUMBER}),({NUMBER})", curve)]


def test_all_pairs_are_in_a_matrix_with_both_sides(tmp_path: Path) -> None:
    plan = plan_of(methods("ica", "affine", "bad"))
    text = report(plan, records_of(plan, {"ica": 1.0, "affine": 0.95, "bad": 0.1}), tmp_path)
    shown = Page(text).text
    assert "corridor : 3 pairs" in shown
    assert "18–2–0" not in shown, "the lower triangle is of the row"
    assert "0–2–18" in shown
    assert re.search(r'class="change better"><b>\+0\.90</b>', text)
    assert re.search(r'class="change worse"><b>0–2–18</b>', text)
    assert re.search(r'class="change unclear"><b>\+0\.05</b>', text)


def test_too_few_worlds_for_the_pairs_are_said_to_be_too_few(tmp_path: Path) -> None:
    plan = plan_of(methods("ica", "affine", "bad"), seeds=range(6))
    shown = Page(report(plan, records_of(plan, {"ica": 1.0, "affine": 0.5, "bad": 0.1}), tmp_path)).text
    assert "6 worlds cannot separate 3 pairs: that takes 7." in shown


def test_a_pair_needs_no_matrix(tmp_path: Path) -> None:
    plan = plan_of(methods("ica", "affine"))
    assert "All pairs" not in report(plan, records_of(plan, {"ica": 1.0, "affine": 0.5}), tmp_path)
    assert "All pairs" not in report(plan_of(methods("ica", "affine", "bad")), [], tmp_path)


def test_of_very_many_variants_some_are_shown_and_all_count(tmp_path: Path) -> None:
    plan = plan_of(methods(*(f"v{k}" for k in range(30))))
    shown = Page(report(plan, records_of(plan, {f"v{k}": k / 30 for k in range(30)}), tmp_path)).text
    assert "corridor : 435 pairs" in shown
    assert "6 more variants are not shown, but count in the family." in shown
    many = plan_of(methods(*(f"v{k}" for k in range(61))), seeds=range(2))
    assert "All pairs" not in report(many, records_of(many, {f"v{k}": 0.5 for k in range(61)}), tmp_path)


def with_spl(plan: Plan, values: dict[str, list[float]]) -> tuple[Plan, list[Record]]:
    """Return a study with SPL as its second metric."""
    spl = {"drive.spl": Metric("spl", help="Path.", better="higher", if_failed=0.0)}
    changed = replace(plan, metrics=(SUCCESS, "drive.spl"), declared={**plan.declared, **spl})
    records = [
        record_of(case, seed, "goal", drive__success=float(spl > 0), drive__spl=spl)
        for case in plan.cases
        for seed, spl in zip(plan.seeds, values[case.variant], strict=True)
    ]
    return changed, records


def test_shares_that_are_not_only_0_or_1_have_profiles(tmp_path: Path) -> None:
    plan = plan_of(methods("ica", "affine"), seeds=range(4))
    study = with_spl(plan, {"ica": [0.9, 0.8, 1.0, 0.0], "affine": [0.5, 0.6, 0.0, 0.0]})
    text = report(*study, tmp_path)
    assert "Performance profiles" in text
    assert "drive.spl of at least" in text
    assert "drive.success of at least" not in text, "its profile is one number"
    without = report(plan, records_of(plan, {"ica": 0.9, "affine": 0.5}), tmp_path)
    assert "Performance profiles" not in without


def test_a_profile_falls_from_the_share_of_successes_to_nothing() -> None:
    values = [0.0, 0.0, 0.6, 0.7, 0.7, 1.0]
    svg = str(profile_chart("corridor", "spl of at least", [Steps("ica", values, "#123456")]))
    found = points(re.search(r'class="line" d="([^"]+)"', svg).group(1))  # type: ignore[union-attr]
    bottom, top = 224.0, 30.0
    shares = [(bottom - y) / (bottom - top) for _, y in found]
    assert shares[0] == pytest.approx(4 / 6, abs=1e-3)
    assert shares[-1] == pytest.approx(0.0, abs=1e-3)
    assert all(x0 <= x1 and a >= b for ((x0, _), a), ((x1, _), b) in pairwise(zip(found, shares, strict=True)))
    assert [round(share * 6) for share in shares] == [4, 4, 3, 3, 2, 2, 1, 1, 0, 0]
    assert "half of 6 runs have at least 0.600" in svg


def test_axes_that_vary_are_drawn_together(tmp_path: Path) -> None:
    plan = plan_of(methods("a", "b", "c", "d"))
    flow = {"a": "lk", "b": "dis", "c": "lk", "d": "dis"}
    plane = {"a": "ica", "b": "ica", "c": "affine", "d": "affine"}
    cases = tuple(replace(c, labels={"plane": plane[c.variant], "flow": flow[c.variant]}) for c in plan.cases)
    crossed = replace(plan, cases=cases, axes={"plane": ("ica", "affine"), "flow": ("lk", "dis")})
    records = records_of(crossed, {"a": 1.0, "b": 0.8, "c": 0.5, "d": 0.1})
    assert report(crossed, records, tmp_path).count('class="strand"') == 4
    assert 'class="strand"' not in report(replace(crossed, within=("flow",)), records, tmp_path)
    assert 'class="strand"' not in report(plan, records_of(plan, dict.fromkeys("abcd", 0.5)), tmp_path)


@pytest.mark.parametrize("better", ["higher", "lower"])
def test_strands_end_at_their_metric_with_the_better_end_up(better: str) -> None:
    strands = [Strand("low", ["ica", "lk"], 0.2), Strand("high", ["ica", "dis"], 0.8)]
    svg = str(parallel_chart("corridor", {"plane": ["ica"], "flow": ["lk", "dis"]}, strands, "spl", better))  # type: ignore[arg-type]
    curves = re.findall(r'class="strand" d="([^"]+)" style="stroke:(#\w+)"><title>(\w+)', svg)
    ends = {name: points(curve)[-1][1] for curve, _, name in curves}
    assert (ends["high"] < ends["low"]) == (better == "higher"), "y grows downwards"
    colours = {name: colour for _, colour, name in curves}
    assert colours == (
        {"low": "#d1495b", "high": "#2a9d8f"} if better == "higher" else {"low": "#2a9d8f", "high": "#d1495b"}
    )


def test_equal_strands_have_one_colour() -> None:
    strands = [Strand(name, [choice], value) for name, choice, value in (("a", "x", 0.0), ("b", "y", 0.0))]
    svg = str(parallel_chart("corridor", {"plane": ["x", "y"]}, strands, "spl", "higher"))
    assert len(set(re.findall(r'style="stroke:(#\w+)"', svg))) == 1
    better = str(parallel_chart("c", {"plane": ["x", "y"]}, [*strands, Strand("c", ["x"], 1.0)], "spl", "higher"))
    first, second, best = re.findall(r'style="stroke:(#\w+)"', better)
    assert first == second != best == "#2a9d8f"


def test_frames_of_their_own_have_no_profile(tmp_path: Path) -> None:
    plan, records = with_spl(
        plan_of(methods("ica", "affine"), seeds=range(2)), {"ica": [0.9, 0.8], "affine": [0.5] * 2}
    )
    spl = replace(plan.declared["drive.spl"], of_frames=True)
    own = replace(
        plan,
        declared={**plan.declared, "drive.spl": spl},
        cases=tuple(replace(case, drives_as=case.variant) for case in plan.cases),
    )
    assert "drive.spl of at least" in report(plan, records, tmp_path)
    assert "drive.spl of at least" not in report(own, records, tmp_path)


def of_own_frames(plan: Plan, alike: Mapping[str, str]) -> Plan:
    """Return a plan whose deciding metric depends on the frames; ``alike``: whose drive each variant's is."""
    spl = replace(plan.declared["drive.spl"], of_frames=True)
    cases = tuple(replace(case, drives_as=alike[case.variant]) for case in plan.cases)
    return replace(plan, declared={**plan.declared, "drive.spl": spl}, cases=cases, metrics=("drive.spl",))


def test_a_rival_that_met_frames_of_its_own_is_not_called_undefined(tmp_path: Path) -> None:
    plan, records = with_spl(plan_of(methods("ica", "affine"), seeds=range(8)), {"ica": [0.9] * 8, "affine": [0.5] * 8})
    text = Page(report(of_own_frames(plan, {"ica": "ica", "affine": "affine"}), records, tmp_path)).text
    assert "affine : drive.spl 0.5000 ≈[0.5000, 0.5000], not compared: own frames. Better" in text
    assert "Not compared: own frames affine 0.5000" in text
    assert "undefined in all runs" not in text


def test_rivals_that_met_frames_of_their_own_do_not_count_as_not_better(tmp_path: Path) -> None:
    values = {"ica": [0.5] * 8, "affine": [0.9] * 8, "gain": [0.9] * 8, "twin": [0.5] * 8}
    plan, records = with_spl(plan_of(methods(*values), seeds=range(8)), values)
    own = of_own_frames(plan, {name: name for name in values})
    text = Page(report(own, records, tmp_path)).text
    assert "ica has drive.spl 0.5000 ≈[0.5000, 0.5000]. affine , gain and twin are not compared: own frames." in text
    assert "others is better" not in text
    some = of_own_frames(plan, {"ica": "ica", "affine": "affine", "gain": "gain", "twin": "ica"})
    text = Page(report(some, records, tmp_path)).text
    assert "None that is compared is better; affine and gain are not compared: own frames." in text
    assert "no common world" not in text


def test_a_mean_of_fewer_worlds_than_were_run_is_told_first(tmp_path: Path) -> None:
    made = plan_of(methods("ica", "affine"), seeds=range(4))
    length = Metric("length_m", unit="m", better="lower", help="Length.")
    plan = replace(made, metrics=("drive.length_m",), declared={**made.declared, "drive.length_m": length})
    records = [
        record_of(case, seed, "goal", drive__length_m=5.0)
        if case.is_base or seed < 1
        else record_of(case, seed, "failed")
        for case in plan.cases
        for seed in plan.seeds
    ]
    warning = "drive.length_m is known in fewer worlds than were run, its mean is of these alone: affine 1 of 4."
    assert warning in report(plan, records, tmp_path)
    assert "fewer worlds than were run" not in report(plan, [r for r in records if r.outcome == "goal"], tmp_path)
