"""The number of worlds that a difference needs: simulated studies of that size find it in 4 of 5 cases."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable

import numpy as np
import pytest
from scipy.stats import binomtest, ttest_1samp

from graphnav.studies.ablation.plan.plan import Plan
from graphnav.studies.ablation.results.compare_variants import compare
from graphnav.studies.ablation.results.records import Record
from graphnav.studies.ablation.results.sample_size import sample_size_texts, worlds_needed

MakePlan = Callable[..., Plan]
MakeRecord = Callable[..., Record]

STUDIES = 4000
TOLERANCE = 0.03
"""Four standard errors of a share of 0.8 in so many studies are 0.025; the formulas are approximations besides."""


def with_moments(mean: float, spread: float) -> np.ndarray:
    """Return values whose mean and standard deviation (n - 1) are these."""
    values = np.array([-1.0, 0.0, 1.0])
    return mean + spread * values


@pytest.mark.parametrize("size", [0.3, 0.6, 1.0])
def test_so_many_worlds_find_a_normal_difference_in_four_of_five_studies(size: float) -> None:
    worlds = worlds_needed(with_moments(size, 1.0), binary=False)
    assert worlds is not None
    drawn = np.random.default_rng(3).normal(size, 1.0, (STUDIES, worlds))
    found = np.mean(ttest_1samp(drawn, 0.0, axis=1).pvalue < 0.05)
    assert found == pytest.approx(0.8, abs=TOLERANCE)


@pytest.mark.parametrize(("won", "lost"), [(6, 2), (4, 1), (10, 4)])
def test_so_many_worlds_find_a_difference_of_shares(won: int, lost: int) -> None:
    differences = np.array([1.0] * won + [-1.0] * lost + [0.0] * (40 - won - lost))
    worlds = worlds_needed(differences, binary=True)
    assert worlds is not None
    counts = np.random.default_rng(3).multinomial(worlds, [won / 40, lost / 40, 1 - (won + lost) / 40], STUDIES)
    # McNemar's test as Connor means it; the exact one finds somewhat fewer.
    statistic = (counts[:, 0] - counts[:, 1]) / np.sqrt(np.maximum(counts[:, 0] + counts[:, 1], 1))
    assert np.mean(np.abs(statistic) > 1.96) == pytest.approx(0.8, abs=TOLERANCE)
    exact = np.mean([binomtest(int(up), int(up + down)).pvalue < 0.05 for up, down, _ in counts[:400] if up + down])
    assert 0.6 < exact < 0.85


def test_more_comparisons_need_more_worlds() -> None:
    one, many = (worlds_needed(with_moments(0.3, 1.0), binary=False, comparisons=m) for m in (1, 17))
    assert one is not None
    assert many is not None
    assert 1.4 < many / one < 2.1, "(2.98 + 0.84)^2 / (1.96 + 0.84)^2 = 1.86"


def test_no_difference_needs_no_number() -> None:
    assert worlds_needed(np.array([-1.0, 1.0]), binary=True) is None
    assert worlds_needed(with_moments(1e-9, 1.0), binary=False) is None
    assert worlds_needed(np.array([1.0, 1.0]), binary=False) == 6, "as few as may be called clear"


def test_the_sentence_is_on_unclear_variants_only(make_plan: MakePlan, make_record: MakeRecord) -> None:
    plan = make_plan(variants=("ica", "worse", "alike"), seeds=range(20), metrics={"drive.success": "higher"})
    arrives = {"ica": 20, "worse": 2, "alike": 18}
    records = [
        make_record(variant, seed, {"drive.success": float(seed < last)})
        for variant, last in arrives.items()
        for seed in range(20)
    ]
    (text,) = sample_size_texts(plan, compare(plan, records), records)
    normal = 2.241402727604947  # of 0.05 / 2 comparisons
    worlds = math.ceil(((normal * math.sqrt(0.1) + 0.8416212335729143 * math.sqrt(0.1 - 0.01)) / 0.1) ** 2)
    assert text == (
        "corridor, alike: drive.success is not clear after 20 worlds; "
        f"a difference of this size would be clear in 4 of 5 studies of about {worlds}"
    )


def test_a_study_that_its_results_stop_has_none(make_plan: MakePlan, make_record: MakeRecord) -> None:
    plan = dataclasses.replace(make_plan(seeds=range(3), metrics={"drive.success": "higher"}), until_clear=True)
    records = [make_record(variant, seed, {"drive.success": 1.0}) for variant in plan.variants for seed in range(3)]
    assert list(sample_size_texts(plan, compare(plan, records), records)) == []


def test_variants_without_runs_count_in_the_family(make_plan: MakePlan, make_record: MakeRecord) -> None:
    found = []
    for variants in (("ica", "alike"), ("ica", "alike", "later", "last")):
        plan = make_plan(variants=variants, seeds=range(20), metrics={"drive.success": "higher"})
        records = [
            make_record(variant, seed, {"drive.success": float(seed < last)})
            for variant, last in {"ica": 20, "alike": 18}.items()
            for seed in range(20)
        ]
        (text,) = sample_size_texts(plan, compare(plan, records), records)
        found.append(int(text.rpartition(" ")[2]))
    assert found[0] < found[1]


def test_where_nothing_differs_no_number_is_given(make_plan: MakePlan, make_record: MakeRecord) -> None:
    plan = make_plan(seeds=range(3), metrics={"drive.success": "higher"})
    records = [make_record(variant, seed, {"drive.success": 1.0}) for variant in plan.variants for seed in range(3)]
    (text,) = sample_size_texts(plan, compare(plan, records), records)
    assert text == "corridor, affine: drive.success is not clear after 3 worlds; they show no difference"


def test_drives_that_the_time_limit_cut_off_are_not_alike(make_plan: MakePlan, make_record: MakeRecord) -> None:
    plan = make_plan(seeds=range(3), metrics={"drive.success": "higher"})
    records = [
        make_record(variant, seed, {"drive.success": 0.0}, outcome="timeout")
        for variant in plan.variants
        for seed in range(3)
    ]
    (text,) = sample_size_texts(plan, compare(plan, records), records)
    assert "every run hit the time limit before it arrived, which shows nothing" in text
    crashed = [dataclasses.replace(one, outcome="contact") for one in records]
    (text,) = sample_size_texts(plan, compare(plan, crashed), crashed)
    assert text.endswith("they show no difference")


def test_a_difference_that_does_not_matter_needs_no_worlds(make_plan: MakePlan, make_record: MakeRecord) -> None:
    plan = make_plan(seeds=range(40), metrics={"drive.success": "higher"})
    records = [
        make_record(variant, seed, {"drive.success": float(seed > 0 or variant == "ica")})
        for variant in plan.variants
        for seed in range(40)
    ]
    (text,) = sample_size_texts(plan, compare(plan, records), records)
    assert text.endswith("after 40 worlds; the difference is smaller than 0.05, the smallest that matters")


def test_a_first_metric_that_no_run_has_does_not_silence_it(make_plan: MakePlan, make_record: MakeRecord) -> None:
    plan = make_plan(seeds=range(3), metrics={"drive.path_length_m": "lower", "drive.success": "higher"})
    records = [make_record(variant, seed, {"drive.success": 1.0}) for variant in plan.variants for seed in range(3)]
    (text,) = sample_size_texts(plan, compare(plan, records), records)
    assert text == "corridor, affine: drive.success is not clear after 3 worlds; they show no difference"


def test_variants_on_which_the_same_is_said_share_a_sentence(make_plan: MakePlan, make_record: MakeRecord) -> None:
    plan = make_plan(("ica", "affine", "gain"), seeds=range(3), metrics={"drive.success": "higher"})
    records = [make_record(variant, seed, {"drive.success": 1.0}) for variant in plan.variants for seed in range(3)]
    (text,) = sample_size_texts(plan, compare(plan, records), records)
    assert text == "corridor, affine, gain: drive.success is not clear after 3 worlds; they show no difference"
