"""Each oracle adds something alone, and behind those before it."""

import dataclasses
from collections.abc import Callable, Mapping

import pytest
from matplotlib.colors import to_hex

from graphnav.core.stage import Metric
from graphnav.studies.ablation.plan.plan import Plan
from graphnav.studies.ablation.report.decomposition import (
    _bounds,
    _figure,
    decomposition_picture,
    loss_table,
    notes,
    sentences,
)
from graphnav.studies.ablation.results import Losses, losses
from graphnav.studies.ablation.results.records import Record
from graphnav.studies.ablation.study.study import Decomposition

MakePlan = Callable[..., Plan]
MakeRecord = Callable[..., Record]

SPL: Mapping[str, tuple[float, ...]] = {
    "none": (0.5, 0.6, 0.7),
    "flow": (0.5, 0.7, 0.7),
    "plane": (0.8, 0.8, 0.9),
    "flow+plane": (0.7, 0.8, 0.9),
}


@pytest.fixture
def plan(make_plan: MakePlan) -> Plan:
    """Return the plan of a decomposition of two stages, in which a true plane leaves the flow unused."""
    made = make_plan(tuple(SPL), metrics={"drive.spl": "higher"})
    driving = {"none": ("flow", "plane"), "flow": ("flow", "plane"), "plane": ("plane",), "flow+plane": ("plane",)}
    cases = tuple(dataclasses.replace(case, driving=driving[case.variant]) for case in made.cases)
    oracles = Decomposition({"flow": "flow.truth", "plane": "plane.truth"}, has_common_drive=False)
    return dataclasses.replace(made, cases=cases, decomposition=oracles)


@pytest.fixture
def found(plan: Plan, make_record: MakeRecord) -> Losses:
    """Return what was lost where in three worlds."""
    records = [
        make_record(variant, seed, {"drive.spl": value})
        for variant, values in SPL.items()
        for seed, value in enumerate(values)
    ]
    (only,) = losses(plan, records)
    return only


def test_each_alone_is_compared_with_the_graph_as_it_is(found: Losses) -> None:
    assert found.as_it_is.mean == pytest.approx(0.6)
    gains = [swap.gain.mean for swap in found.single if swap.gain is not None]
    assert gains == pytest.approx([0.1 / 3, 0.7 / 3])


def test_each_step_is_compared_with_the_one_before(found: Losses) -> None:
    assert [swap.stage for swap in found.cumulative] == ["flow", "plane"]
    gains = [swap.gain.mean for swap in found.cumulative if swap.gain is not None]
    assert gains == pytest.approx([0.1 / 3, 0.5 / 3])
    last = found.cumulative[-1]
    assert last.estimate is not None
    assert found.as_it_is.mean + sum(gains) == pytest.approx(last.estimate.mean)


def test_swaps_that_nothing_reads_are_told(plan: Plan, found: Losses) -> None:
    assert [swap.unused for swap in found.cumulative] == [(), ("flow",)]
    assert any("With the oracle of plane, flow no longer drives" in note for note in notes(plan, [found]))


def test_the_sentence_names_the_largest_step(plan: Plan, found: Losses) -> None:
    text = " ".join(sentences(plan, found))
    assert text.startswith("drive.spl on corridor is 0.6")
    assert "The largest step is that of plane, +0.17 [+0.02, +0.31]" in text
    assert [cells[0].text for cells in loss_table(found).cells()] == ["nothing", "flow", "plane"]


def test_runs_that_all_hit_the_time_limit_conclude_nothing(plan: Plan, make_record: MakeRecord) -> None:
    records = [
        make_record(variant, 0, {"drive.spl": 0.1 * k, "drive.success": 0.0}, outcome="timeout")
        for k, variant in enumerate(SPL)
    ]
    (cut_off,) = losses(plan, records)
    assert cut_off.is_cut_off
    (only,) = sentences(plan, cut_off)
    assert only.startswith("drive.spl on corridor: every run hit the time limit before it arrived")
    arrived = dataclasses.replace(records[-1], outcome="goal", metrics={"drive.spl": 0.3, "drive.success": 1.0})
    assert not losses(plan, [*records[:-1], arrived])[0].is_cut_off
    lasted = dataclasses.replace(records[-1], metrics={"drive.spl": 0.3, "drive.success": 1.0})
    assert not losses(plan, [*records[:-1], lasted])[0].is_cut_off, "success is to last until the limit"
    endless = dataclasses.replace(plan, declared={"drive.spl": plan.metric("drive.spl")})
    assert not losses(endless, records)[0].is_cut_off, "no stage declares what it is to arrive"


def test_a_step_without_runs_is_left_open(plan: Plan, make_record: MakeRecord) -> None:
    records = [make_record("none", 0, {"drive.spl": 0.5}), make_record("flow", 0, {"drive.spl": 0.6})]
    (partly,) = losses(plan, records)
    assert [swap.estimate is None for swap in partly.cumulative] == [False, True]
    assert decomposition_picture([partly]).startswith(b"\x89PNG")


def test_other_studies_have_none(make_plan: MakePlan, make_record: MakeRecord) -> None:
    assert losses(make_plan(), [make_record("ica", 0, {"drive.spl": 1.0})]) == ()


def test_the_picture_is_the_same_each_time(found: Losses) -> None:
    assert decomposition_picture([found]) == decomposition_picture([found])
    drawn = decomposition_picture([found], "svg").decode()
    assert drawn == decomposition_picture([found], "svg").decode()
    assert "+ flow" in drawn
    assert "+0.167" in drawn


def test_what_depends_on_frames_is_taken_on_the_common_drive(plan: Plan, make_record: MakeRecord) -> None:
    auroc = Metric("auroc", help="Area.", better="higher", of_frames=True)
    oracles = dataclasses.replace(plan.decomposition or Decomposition({}, has_common_drive=True), has_common_drive=True)
    drives = {"corridor, own": "own drive", "corridor, oracle": "oracle's drive"}
    cases = tuple(
        dataclasses.replace(case, graph=graph, labels={"oracles": case.variant, "drive": label}, folder=f"{graph}/{n}")
        for graph, label in drives.items()
        for n, case in enumerate(plan.cases)
    )
    both = dataclasses.replace(
        plan,
        cases=cases,
        graphs=tuple(drives),
        metrics=("drive.spl", "sight.auroc"),
        declared={**plan.declared, "sight.auroc": auroc},
        decomposition=oracles,
    )
    values = {"corridor, own": 0.5, "corridor, oracle": 0.9}
    records = [
        make_record(variant, 0, {"drive.spl": value, "sight.auroc": value}, graph=graph)
        for graph, value in values.items()
        for variant in SPL
    ]
    spl, sight = losses(both, records)
    assert (spl.is_common, spl.as_it_is.mean) == (False, 0.5)
    assert (sight.is_common, sight.as_it_is.mean) == (True, 0.9)


def test_the_legend_fits_into_the_picture(found: Losses) -> None:
    figure = _figure([found])
    figure.set_dpi(100)
    figure.draw_without_rendering()
    (legend,) = figure.legends
    box = legend.get_window_extent()
    assert 0 <= box.x0 < box.x1 <= figure.bbox.width


def test_intervals_end_at_the_bounds_of_the_metric_alone(found: Losses) -> None:
    (swap,) = (swap for swap in found.single if swap.stage == "plane")
    assert swap.gain is not None
    assert swap.estimate is not None
    high = found.as_it_is.mean + swap.gain.high
    wide = dataclasses.replace(swap, gain=dataclasses.replace(swap.gain, high=1.5))
    assert _bounds(found, swap, swap.estimate.mean)[1] == pytest.approx(high)
    assert _bounds(found, wide, swap.estimate.mean)[1] == pytest.approx(found.as_it_is.mean + 1.5), "of metres"
    shares = dataclasses.replace(found, span=(0.0, 1.0))
    assert _bounds(shares, wide, swap.estimate.mean)[1] == 1.0


def test_green_is_better_where_lower_is(found: Losses) -> None:
    bars = []
    for better in ("higher", "lower"):
        (axes,) = _figure([dataclasses.replace(found, better=better)]).axes
        bars.append([to_hex(patch.get_facecolor()) for patch in axes.patches])
    assert bars == [["#2a9d8f"] * 2, ["#d1495b"] * 2]


def test_a_step_without_the_metric_keeps_its_place(plan: Plan, make_record: MakeRecord) -> None:
    records = [
        make_record(variant, seed, {"drive.spl": value})
        for variant, values in SPL.items()
        if variant != "flow"
        for seed, value in enumerate(values)
    ]
    (axes,) = _figure(list(losses(plan, records))).axes
    labels = [label.get_text().split("\n") for label in axes.get_xticklabels()]
    assert labels == [["as it is", "0.600"], ["+ flow", "not known"], ["+ plane", "0.800"], ["all oracles", "0.800"]]
    assert not axes.patches, "the step of both is not that of the plane"


def test_metrics_of_frames_have_no_gain_across_different_frames(plan: Plan, make_record: MakeRecord) -> None:
    auroc = Metric("auroc", help="Area.", better="higher", of_frames=True)
    cases = tuple(dataclasses.replace(case, drives_as=case.variant) for case in plan.cases)
    own = dataclasses.replace(
        plan, cases=cases, metrics=("sight.auroc",), declared={**plan.declared, "sight.auroc": auroc}
    )
    records = [make_record(variant, seed, {"sight.auroc": 0.5}) for variant in SPL for seed in range(3)]
    (of,) = losses(own, records)
    assert [swap.gain for swap in (*of.single, *of.cumulative)] == [None] * 4
    assert all(swap.estimate is not None for swap in of.cumulative)
    assert "No oracle improves it." not in " ".join(sentences(own, of))
