"""Families of comparisons: variants with the base, any two variants, all pairs."""

from __future__ import annotations

import math
from collections.abc import Callable

import pytest

from graphnav.studies.ablation.plan.plan import Plan
from graphnav.studies.ablation.results.compare_variants import all_pairs, compare, contrasts
from graphnav.studies.ablation.results.comparison import Difference
from graphnav.studies.ablation.results.records import Record
from graphnav.studies.ablation.results.statistics import bonett_price

MakePlan = Callable[..., Plan]
MakeRecord = Callable[..., Record]
Study = tuple[Plan, list[Record]]
SHIFTS = {"base": 0.0, "much": 5.0, "none": 0.0, "less": -5.0}


@pytest.fixture
def study(make_plan: MakePlan, make_record: MakeRecord) -> Study:
    """Return a study of 8 worlds on two graphs; "much" and "less" differ from the base in every world."""
    plan = make_plan(
        variants=(*SHIFTS, "twin"),
        seeds=range(8),
        metrics={"a.x": "higher", "a.y": "lower"},
        graphs=("one", "two"),
        same_as={"twin": "much"},
    )
    records = [
        make_record(variant, seed, {"a.x": shift + math.sin(9 * seed + len(variant)), "a.y": shift}, graph=graph)
        for graph in plan.graphs
        for variant, shift in (SHIFTS | {"twin": 5.0}).items()
        for seed in plan.seeds
    ]
    return plan, records


def test_the_variants_of_a_graph_are_one_family(study: Study) -> None:
    comparison = compare(*study)
    assert comparison.primary == "a.x"
    rows = {(row.case.graph, row.case.variant): row.differences for row in comparison.rows}
    for graph in ("one", "two"):
        found = rows[graph, "much"]["a.x"]
        assert found.p == 2 / 2**8
        assert found.significance is not None
        assert (found.significance.family, found.significance.p_holm) == (3, 3 * 2 / 2**8)
        assert found.is_clear
        assert rows[graph, "twin"]["a.x"] == found, "the same runs count once"
        assert not rows[graph, "none"]["a.x"].is_clear
        assert rows[graph, "much"]["a.y"].significance is None
        assert not rows[graph, "much"]["a.y"].is_clear, "it does not decide"


def test_variants_without_runs_belong_to_the_family(study: Study) -> None:
    plan, records = study
    some = [record for record in records if record.variant in {"base", "much"}]
    found = compare(plan, some).of_graph("one")[1].differences["a.x"].significance
    assert found is not None
    assert (found.family, found.p_holm) == (3, 3 * 2 / 2**8)


def test_any_two_variants_are_compared(study: Study) -> None:
    one, two = contrasts(*study, [("less", "much")])
    assert (one.graph, two.graph, one.first, one.second) == ("one", "two", "less", "much")
    found = one.differences["a.x"]
    assert (found.won, found.tied, found.lost, found.p) == (0, 0, 8, 2 / 2**8)
    assert found.significance is not None
    assert (found.significance.family, found.significance.p_holm) == (1, found.p)
    assert one.differences["a.y"].won == 8, "lower is better"
    assert [estimate.mean for estimate in one.estimates["a.y"]] == [-5.0, 5.0]


def test_the_contrasts_of_a_graph_are_one_family(study: Study) -> None:
    found = contrasts(*study, [("less", "much"), ("none", "much"), ("less", "much")])
    assert [(one.graph, one.first) for one in found] == [(g, v) for g in ("one", "two") for v in ("less", "none")]
    significance = found[0].differences["a.x"].significance
    assert significance is not None
    assert significance.family == 2


def test_all_pairs_are_one_family_and_have_two_sides(study: Study) -> None:
    pairs, _ = all_pairs(*study)
    assert pairs.variants == ("base", "much", "none", "less")
    assert len(pairs.differences) == 12
    for (a, b), found in pairs.differences.items():
        other = pairs.differences[b, a]
        assert found.significance is not None
        assert found.significance == other.significance
        assert found.significance.family == 6
        assert (found.mean, found.low, found.won) == (-other.mean, -other.high, other.lost)
    assert pairs.differences["much", "base"].mean == compare(*study).of_graph("one")[1].differences["a.x"].mean


def test_a_study_that_has_not_begun_has_no_pairs(study: Study) -> None:
    plan, _ = study
    assert all(not pairs.differences for pairs in all_pairs(plan, []))
    assert all(not one.differences for one in contrasts(plan, [], [("base", "much")]))


@pytest.mark.parametrize(("won", "lost", "chance"), [(8, 0, 1.0), (0, 8, 0.0), (2, 2, 0.5), (3, 1, 0.625), (0, 0, 0.5)])
def test_the_chance_to_be_better_counts_ties_by_half(won: int, lost: int, chance: float) -> None:
    found = Difference(0.0, 0.0, 0.0, 8, won, lost).probability_better
    assert found.mean == chance
    assert found.low < chance < found.high or chance in {0.0, 1.0}
    low, high = bonett_price(won, lost, 8)
    assert (found.low, found.high) == ((1 + low) / 2, (1 + high) / 2)
    assert 0 <= found.low < found.high <= 1
