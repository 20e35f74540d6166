"""Two studies side by side."""

from __future__ import annotations

import dataclasses
import io
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import pytest

from graphnav.core.errors import UserError
from graphnav.core.machine.console import Console
from graphnav.core.stage import Metric
from graphnav.studies.ablation.plan.plan import Plan
from graphnav.studies.ablation.plan.provenance import shows_same_drive
from graphnav.studies.ablation.report.markdown import paired_studies_markdown
from graphnav.studies.ablation.report.terminal import print_paired_studies
from graphnav.studies.ablation.results.compare_studies import pair_studies
from graphnav.studies.ablation.results.compare_variants import compare
from graphnav.studies.ablation.results.fail_condition import failed_cases, parse_fail_conditions
from graphnav.studies.ablation.results.records import Record

MakePlan = Callable[..., Plan]
Runs = Callable[[str, Sequence[int], Sequence[float]], list[Record]]


@pytest.fixture
def runs(make_record: Callable[..., Record]) -> Runs:
    """Return what makes runs of a variant with a time and a success each."""

    def make(variant: str, seeds: Sequence[int], times_s: Sequence[float]) -> list[Record]:
        return [
            make_record(variant, seed, {"drive.time_s": time_s, "drive.success": float(time_s < 20)})
            for seed, time_s in zip(seeds, times_s, strict=True)
        ]

    return make


def test_the_same_worlds_are_compared(make_plan: MakePlan, runs: Runs) -> None:
    before = make_plan(seeds=range(4), metrics={"drive.time_s": "lower", "drive.success": "higher"})
    after = dataclasses.replace(before, seeds=(2, 3, 4), versions={"graphnav": "0.2.0"})
    pairing = pair_studies(
        before,
        runs("ica", range(4), [10, 20, 30, 40]) + runs("affine", [0, 1], [1, 2]),
        after,
        runs("ica", [2, 3, 4], [15, 41, 9]),
    )
    (row,) = pairing.rows
    assert (row.variant, row.seeds, row.only_a, row.only_b) == ("ica", (2, 3), (0, 1), (4,))
    assert (row.estimates_a["drive.time_s"].mean, row.estimates_b["drive.time_s"].mean) == (35.0, 28.0)
    found = row.differences["drive.time_s"]
    assert (found.mean, found.n, found.won, found.lost) == (-7.0, 2, 1, 1)
    assert (row.differences["drive.success"].won, row.differences["drive.success"].lost) == (1, 0)
    assert pairing.only_a == (("corridor", "affine"),)
    assert pairing.only_b == ()
    assert pairing.different_versions == {"graphnav": ("0.1.0", "0.2.0")}

    text = paired_studies_markdown(pairing)
    out = io.StringIO()
    print_paired_studies(Console(file=out, width=30), pairing)
    for shown in (text, out.getvalue()):
        for part in ("35 ≈[-29, 99]", "28 ≈[-137, 193]", "drive.time_s ↓", "corridor, affine: only A has runs of it"):
            assert part in shown
        assert "corridor, ica: only B has the seeds 4 (1)" in shown
        assert "graphnav: 0.1.0 in A, 0.2.0 in B" in shown


def test_a_study_does_not_differ_from_itself(make_plan: MakePlan, runs: Runs) -> None:
    plan = make_plan(seeds=range(9))
    records = runs("ica", range(9), range(9)) + runs("affine", range(9), range(3, 12))
    pairing = pair_studies(plan, records, plan, list(reversed(records)))
    assert [row.variant for row in pairing.rows] == ["ica", "affine"]
    for row, single in zip(pairing.rows, compare(plan, records).rows, strict=True):
        assert row.estimates_a == row.estimates_b == single.estimates
        assert all(found.mean == found.won == found.lost == 0 for found in row.differences.values())
    assert pairing.only_a == pairing.only_b == ()
    assert "Only in one" not in paired_studies_markdown(pairing)


def test_failures_count_as_in_every_table(make_plan: MakePlan, runs: Runs) -> None:
    plan = make_plan()
    good = runs("ica", range(3), [10, 10, 10])
    broken = [dataclasses.replace(record, outcome="failed", failure="no") for record in good[:1]]
    (row,) = pair_studies(plan, good, plan, broken + good[1:]).rows
    assert row.differences["drive.success"].lost == 1
    assert row.differences["drive.time_s"].n == 2


def test_studies_without_a_common_run_cannot_be_compared(make_plan: MakePlan, runs: Runs) -> None:
    a, b = make_plan(seeds=(0, 1)), make_plan(seeds=(2, 3))
    with pytest.raises(UserError, match=r"have no run in common: .*\n  compare studies of the same"):
        pair_studies(a, runs("ica", [0, 1], [1, 2]), b, runs("ica", [2, 3], [1, 2]))


def test_what_is_the_same_graph_in_both_is_told_once(make_plan: MakePlan, runs: Runs) -> None:
    plan = make_plan(variants=("ica", "twin"), same_as={"twin": "ica"})
    records = runs("ica", range(3), [1, 2, 3]) + runs("twin", range(3), [1, 2, 3])
    pairing = pair_studies(plan, records, plan, records)
    assert [row.variant for row in pairing.rows] == ["ica"]
    assert pairing.only_a == pairing.only_b == ()
    other = make_plan(variants=("ica", "twin"))
    assert [row.variant for row in pair_studies(plan, records, other, records).rows] == ["ica", "twin"]


def test_an_interval_ends_at_the_bounds_of_its_metric(make_plan: MakePlan, make_record: Callable[..., Record]) -> None:
    made = make_plan(("ica",), range(2), metrics={"drive.spl": "higher"})
    spl = dataclasses.replace(made.declared["drive.spl"], bounds=(0.0, 1.0))
    plan = dataclasses.replace(made, declared={**made.declared, "drive.spl": spl})
    records = [make_record("ica", seed, {"drive.spl": value}) for seed, value in enumerate((0.9, 1.0))]
    (row,) = pair_studies(plan, records, plan, records).rows
    assert row.estimates_a["drive.spl"].high == row.estimates_b["drive.spl"].high == 1.0
    assert row.estimates_a["drive.spl"].low == pytest.approx(0.95 - 12.706 * 0.05, abs=1e-3)


GRAPH = """\
run: {{until_s: 12.0, seed: 7}}
stages:
  robot: {{use: world.toy, with: {{size: 3}}, in: {{command: steer.twist}}}}
  steer: {{use: steer.way, in: {{map: robot.map}}}}
  plane: {{use: plane.ica, with: {{gain: {gain}}}, in: {{image: robot.image}}}}
"""
CODE = {"graphnav": "1", "code of world": "a", "code of steer": "b", "code of plane": "c"}


def seeing(make_plan: MakePlan, gain: int = 1, versions: Mapping[str, str] | None = None) -> Plan:
    """Return a plan whose only metric depends on the frames that a planned way meets."""
    made = make_plan(("ica",), range(8), {"sight.auroc": "higher"})
    auroc = Metric("auroc", help="Area.", better="higher", of_frames=True)
    (case,) = made.cases
    case = dataclasses.replace(case, driving=("steer",), graph_yaml=GRAPH.format(gain=gain))
    declared = {**made.declared, "sight.auroc": auroc}
    return dataclasses.replace(made, cases=(case,), declared=declared, versions={**CODE, **(versions or {})})


@pytest.mark.parametrize(
    ("changed", "is_compared"),
    [
        ({}, True),
        ({"gain": 2, "versions": {"code of plane": "d"}}, True),
        ({"versions": {"code of steer": "d"}}, False),
        ({"versions": {"code of world": "d"}}, False),
        ({"versions": {"code of world": ""}}, False),
        ({"versions": {"graphnav": "2"}}, False),
    ],
)
def test_what_depends_on_frames_is_compared_where_the_drive_is_unchanged(
    changed: dict[str, Any], is_compared: bool, make_plan: MakePlan, make_record: Callable[..., Record]
) -> None:
    before, after = seeing(make_plan), seeing(make_plan, **changed)
    runs_a, runs_b = (
        [make_record("ica", seed, {"sight.auroc": value + seed / 1000}) for seed in range(8)] for value in (0.5, 0.9)
    )
    pairing = pair_studies(before, runs_a, after, runs_b)
    assert ("sight.auroc" in pairing.rows[0].differences) == is_compared
    text = paired_studies_markdown(pairing)
    assert ("| own frames |" in text) == ("Own frames: the plans do not show" in text) == (not is_compared)
    assert "0.5035" in text
    shown = io.StringIO()
    print_paired_studies(Console(file=shown, width=300), pairing)
    assert ("own frames" in shown.getvalue()) == (not is_compared)
    condition = parse_fail_conditions(["sight.auroc < -0.5"])
    assert [case.is_of_frames for case in failed_cases(condition, pairing)] == ([] if is_compared else [True])


def test_another_time_or_drive_is_not_shown_to_be_the_same(make_plan: MakePlan) -> None:
    before = seeing(make_plan)
    (case,) = before.cases
    for old, new in (("12.0", "5.0"), ("size: 3", "size: 4"), ("steer.way", "steer.pca"), (case.graph_yaml, "")):
        other = dataclasses.replace(case, graph_yaml=case.graph_yaml.replace(old, new))
        assert not shows_same_drive(before, case, before, other), new
    assert shows_same_drive(before, case, before, case)
