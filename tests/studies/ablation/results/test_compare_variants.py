"""Rows of a table, worked by hand."""

from __future__ import annotations

import math
import random
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from graphnav.studies.ablation.plan.plan import Plan
from graphnav.studies.ablation.results.compare_variants import compare
from graphnav.studies.ablation.results.records import Record
from graphnav.studies.ablation.results.statistics import bonett_price, student, wilson

MakePlan = Callable[..., Plan]
MakeRecord = Callable[..., Record]


def test_means_and_differences_over_the_same_worlds(make_plan: MakePlan, make_record: MakeRecord) -> None:
    plan = make_plan(seeds=range(4), metrics={"drive.success": "higher", "drive.time_s": "lower"})
    times = {"ica": [10.0, 20.0, 30.0, 40.0], "affine": [12.0, 18.0, 36.0]}
    success = {"ica": [1.0, 1.0, 0.0, 1.0], "affine": [1.0, 0.0, 0.0]}
    records = [
        make_record(name, seed, {"drive.time_s": time_s, "drive.success": success[name][seed]})
        for name in times
        for seed, time_s in enumerate(times[name])
    ]
    base, affine = compare(plan, records).rows
    assert (base.runs, affine.runs) == (4, 3)
    assert base.estimates["drive.success"].mean == 0.75
    assert (base.estimates["drive.success"].low, base.estimates["drive.success"].high) == wilson(3, 4)
    assert base.estimates["drive.time_s"].mean == 25.0
    assert base.differences == {}

    time = affine.differences["drive.time_s"]
    assert (time.mean, time.n, time.won, time.lost) == pytest.approx(((2 - 2 + 6) / 3, 3, 1, 2))
    assert (time.low, time.high) == student(np.array([2.0, -2.0, 6.0]))
    won = affine.differences["drive.success"]
    assert (won.mean, won.n, won.won, won.lost) == pytest.approx((-1 / 3, 3, 0, 1))
    assert (won.low, won.high) == bonett_price(0, 1, 3)


def test_worlds_without_the_figure_shrink_n_and_are_not_zero(make_plan: MakePlan, make_record: MakeRecord) -> None:
    plan = make_plan(seeds=range(5))
    records = [make_record("ica", seed, {"sight.auroc": 0.5 + 0.1 * seed} if seed else {}) for seed in range(5)]
    records += [make_record("affine", seed, {"sight.auroc": 0.9} if seed < 3 else {}) for seed in range(5)]
    base, affine = compare(plan, records).rows
    assert (base.estimates["sight.auroc"].n, base.estimates["sight.auroc"].mean) == pytest.approx((4, 0.75))
    assert (affine.estimates["sight.auroc"].n, affine.estimates["sight.auroc"].mean) == pytest.approx((3, 0.9))
    found = affine.differences["sight.auroc"]
    assert (found.n, found.mean, found.won, found.lost) == pytest.approx((2, 0.25, 2, 0))


def test_failed_runs_have_no_success_and_say_nothing_else(make_plan: MakePlan, make_record: MakeRecord) -> None:
    plan = make_plan(seeds=range(3))
    good = {"drive.success": 1.0, "drive.duration_s": 30.0}
    records = [make_record("ica", seed, good) for seed in range(3)]
    records += [make_record("affine", 0, good)]
    records += [
        make_record(
            "affine",
            seed,
            {"drive.success": 0.0, "drive.duration_s": 0.3},
            outcome="failed",
            failure=f"stage 'plane' (plane.affine) failed at {seed}.35 s: no plane",
            cause="stage 'plane' (plane.affine) failed: no plane",
        )
        for seed in (1, 2)
    ]
    row = compare(plan, records).rows[1]
    assert row.estimates["drive.success"].mean == pytest.approx(1 / 3)
    assert (row.estimates["drive.duration_s"].n, row.estimates["drive.duration_s"].mean) == (1, 30.0)
    assert row.differences["drive.success"].lost == 2
    assert row.differences["drive.duration_s"].n == 1
    assert row.outcomes == {"goal": 1, "failed": 2}
    assert row.failures == {"stage 'plane' (plane.affine) failed: no plane": 2}, "one cause, whenever it struck"


def test_one_world_says_nothing_about_how_worlds_scatter(make_plan: MakePlan, make_record: MakeRecord) -> None:
    records = [make_record(name, 0, {"sight.auroc": 0.7}) for name in ("ica", "affine")]
    row = compare(make_plan(), records).rows[1]
    for found in (row.estimates["sight.auroc"], row.differences["sight.auroc"]):
        assert found.n == 1
        assert math.isnan(found.low)
        assert math.isnan(found.high)


def test_derived_metrics_are_computed_run_by_run(make_plan: MakePlan, make_record: MakeRecord) -> None:
    text = "sight.auroc / twin.auroc"
    plan = make_plan(seeds=range(2), metrics={text: "higher"})
    records = [
        make_record("ica", 0, {"sight.auroc": 0.8, "twin.auroc": 0.8}),
        make_record("ica", 1, {"sight.auroc": 0.4, "twin.auroc": 0.8}),
        make_record("affine", 0, {"sight.auroc": 0.3, "twin.auroc": 0.6}),
        make_record("affine", 1, {"sight.auroc": 0.3}),
    ]
    base, affine = compare(plan, records).rows
    assert base.estimates[text].mean == pytest.approx(0.75)
    assert (affine.differences[text].n, affine.differences[text].mean) == pytest.approx((1, -0.5))


def test_only_metrics_that_are_shares_of_worlds_get_their_intervals(
    make_plan: MakePlan, make_record: MakeRecord
) -> None:
    """A true flow errs by exactly 0 px: no reason to say that it might err by 0.07."""
    plan = make_plan(variants=("truth", "dis"), seeds=range(50))
    true = {"sense.epe_px": 0.0, "drive.success": 1.0}
    records = [make_record("truth", seed, true) for seed in range(50)]
    (alone, _) = compare(plan, records).rows
    assert alone.estimates["sense.epe_px"].high == 0.0, "a metric with a unit is not a share of worlds"
    records += [make_record("dis", seed, {"sense.epe_px": 0.1, "drive.success": 1.0}) for seed in range(50)]
    truth, dis = compare(plan, records).rows
    assert not dis.differences["drive.success"].is_clear
    assert dis.differences["sense.epe_px"].is_clear
    assert (truth.estimates["sense.epe_px"].low, truth.estimates["sense.epe_px"].high) == (0.0, 0.0)
    assert truth.estimates["drive.success"].low == pytest.approx(0.9287, abs=1e-4)
    assert dis.differences["drive.success"].low == pytest.approx(-0.0533, abs=1e-4)


def test_intervals_end_where_the_metric_does(make_plan: MakePlan, make_record: MakeRecord) -> None:
    plan = make_plan(seeds=range(4), metrics={"a.x": "higher", "a.y": "higher"})
    declared = {**plan.declared, "a.x": replace(plan.metric("a.x"), bounds=(0.0, 1.0))}
    values = [0.0, 0.9, 1.0, 1.0]
    records = [make_record("ica", seed, {"a.x": value, "a.y": value}) for seed, value in enumerate(values)]
    found = compare(replace(plan, declared=declared), records).rows[0].estimates
    low, high = student(np.array(values))
    assert high > 1.0
    assert (found["a.x"].low, found["a.x"].high) == (max(low, 0.0), 1.0)
    assert (found["a.y"].low, found["a.y"].high) == (low, high), "nothing is known of its bounds"


def test_the_interval_of_what_cannot_be_negative_is_not(make_plan: MakePlan, make_record: MakeRecord) -> None:
    plan = make_plan(seeds=range(4), metrics={"a.x": "lower", "a.x / a.y": "lower", "a.x - a.y": "lower"})
    declared = {name: replace(plan.metric(name), bounds=(0.0, None)) for name in ("a.x", "a.y")}
    values = [0.0, 0.0, 0.1, 9.0]
    records = [make_record("ica", seed, {"a.x": value, "a.y": 1.0}) for seed, value in enumerate(values)]
    found = compare(replace(plan, declared=declared), records).rows[0].estimates
    low, high = student(np.array(values))
    assert low < 0.0
    for column in ("a.x", "a.x / a.y"):
        assert (found[column].low, found[column].high) == (0.0, high)
    assert found["a.x - a.y"].low == pytest.approx(low - 1.0), "a difference may be negative"


def test_directions_come_from_the_plan(make_plan: MakePlan, make_record: MakeRecord) -> None:
    records = [make_record("ica", 0, {"a.x": 2.0, "b.x": 1.0}), make_record("affine", 0, {"a.x": 1.0, "b.x": 1.0})]
    for plan, won in (
        (make_plan(), 0),
        (make_plan(lower=("a.x",)), 1),
        (make_plan(metrics={"a.x": "lower"}), 1),
    ):
        found = compare(plan, records).rows[1].differences["a.x"]
        assert (found.won, found.lost) == (won, 1 - won)
    plan = make_plan(lower=("a.x",))
    assert plan.better("a.x / b.x") == "lower"
    assert plan.better("b.x - a.x") == "higher"


def test_a_case_that_is_the_base_does_not_differ_from_it(make_plan: MakePlan, make_record: MakeRecord) -> None:
    plan = make_plan(variants=("ica", "same", "affine"), same_as={"same": "ica"})
    records = [make_record(name, seed, {"a.x": 1.0}) for name in plan.variants for seed in plan.seeds]
    rows = compare(plan, records).rows
    assert [bool(row.differences) for row in rows] == [False, False, True]
    assert rows[1].estimates == rows[0].estimates


def test_a_study_that_has_not_begun_has_empty_rows(make_plan: MakePlan) -> None:
    for plan in (make_plan(), make_plan(metrics={"a.x": "higher"})):
        rows = compare(plan, []).rows
        assert [(row.runs, row.estimates, row.differences) for row in rows] == [(0, {}, {})] * 2


def test_the_order_of_runs_does_not_count(make_plan: MakePlan, make_record: MakeRecord) -> None:
    rng = random.Random(0)
    plan = make_plan(variants=("ica", "affine", "gain"), graphs=("corridor", "pillars"), seeds=range(9))
    records = [
        make_record(variant, seed, {"a.x": rng.random(), "a.y": float(rng.random() < 0.5)}, graph=graph)
        for graph in plan.graphs
        for variant in plan.variants
        for seed in plan.seeds
    ]
    first = compare(plan, records)
    rng.shuffle(records)
    assert compare(plan, records) == first
    assert [row.case.variant for row in first.of_graph("pillars")] == list(plan.variants)


def test_times_are_the_median_over_runs(make_plan: MakePlan, make_record: MakeRecord) -> None:
    records = [make_record("ica", seed, p50_ms=p50_ms) for seed, p50_ms in enumerate([1.0, 9.0, 2.0])]
    assert compare(make_plan(), records).rows[0].p50_ms == {"plane": 2.0}


@pytest.mark.parametrize(("worlds", "is_clear"), [(2, False), (5, False), (6, True), (50, True)])
def test_few_worlds_make_no_difference_clear(
    make_plan: MakePlan, make_record: MakeRecord, worlds: int, is_clear: bool
) -> None:
    plan = make_plan(seeds=range(worlds))
    records = [make_record("ica", seed, {"a.x": 0.5}) for seed in range(worlds)]
    records += [make_record("affine", seed, {"a.x": 0.6}) for seed in range(worlds)]
    assert compare(plan, records).rows[1].differences["a.x"].is_clear == is_clear
