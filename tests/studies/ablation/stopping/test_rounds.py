"""Which worlds are added, and what is reported of a study that was stopped by its results."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import pytest

from graphnav.core.errors import GraphnavError, UserError
from graphnav.core.stage import Metric
from graphnav.studies.ablation.plan.plan import Job, Plan
from graphnav.studies.ablation.report.markdown import table_markdown
from graphnav.studies.ablation.results import compare
from graphnav.studies.ablation.results.records import Record, relative_metrics
from graphnav.studies.ablation.stopping import check_stopping, decisions, jobs_of_next_round, stopping_texts

MakePlan = Callable[..., Plan]
MakeRecord = Callable[..., Record]
Success = Callable[[str, int], bool]


@pytest.fixture
def plan(make_plan: MakePlan) -> Plan:
    plan = make_plan(variants=("ica", "worse", "alike"), seeds=range(100, 123), metrics={"drive.success": "higher"})
    return dataclasses.replace(plan, until_clear=True)


def rounds_of(
    plan: Plan, make_record: MakeRecord, succeeds: Success
) -> tuple[list[Record], list[set[tuple[str, int]]]]:
    """Return the runs of a study of which each round is made at once, and the rounds."""
    records: list[Record] = []
    rounds: list[set[tuple[str, int]]] = []

    def is_made(job: Job) -> bool:
        return any((record.variant, record.seed) == (job.case.variant, job.seed) for record in records)

    while jobs := jobs_of_next_round(plan, records, is_made):
        rounds.append({(job.case.variant, job.seed) for job in jobs})
        records += [
            make_record(variant, seed, {"drive.success": float(succeeds(variant, seed))})
            for variant, seed in sorted(rounds[-1])
        ]
    return records, rounds


def test_a_decided_variant_gets_no_more_worlds_and_the_others_all(plan: Plan, make_record: MakeRecord) -> None:
    records, rounds = rounds_of(plan, make_record, lambda variant, _: variant != "worse")
    assert rounds[0] == {(variant, seed) for variant in plan.variants for seed in range(100, 105)}
    assert rounds[1] == {(variant, seed) for variant in plan.variants for seed in range(105, 110)}
    assert rounds[2] == {(variant, seed) for variant in ("ica", "alike") for seed in range(110, 115)}
    assert rounds[4] == {(variant, seed) for variant in ("ica", "alike") for seed in range(120, 123)}
    assert len(rounds) == 5
    said = list(stopping_texts(plan, records))
    assert said[0].startswith("Stopped by --until-clear: 5 worlds at a time were added until drive.success")
    assert said[1:] == [
        "corridor, worse: told from the base after 10 worlds",
        "corridor, alike: not told from the base after 23 worlds",
    ]


def test_the_reference_runs_on_where_what_decides_is_relative_to_it(
    make_plan: MakePlan, make_record: MakeRecord
) -> None:
    name = "drive.oracle_spl"
    of_oracle = Metric(
        "oracle_spl", help="x", better="higher", if_failed=0.0, relative_to="path_length_m", bounds=(0.0, 1.0)
    )
    made = make_plan(("ica", "oracle", "alike"), range(40), {name: "higher"})
    declared = {**made.declared, name: of_oracle}
    plan = dataclasses.replace(made, until_clear=True, reference="oracle", declared=declared)
    path_m = {"ica": 14.0, "oracle": 7.0, "alike": 14.0}
    records: list[Record] = []

    def is_made(job: Job) -> bool:
        return any((record.variant, record.seed) == (job.case.variant, job.seed) for record in records)

    def known() -> list[Record]:
        more = relative_metrics(plan, records)
        return [dataclasses.replace(one, metrics={**one.metrics, **of}) for one, of in zip(records, more, strict=True)]

    while jobs := jobs_of_next_round(plan, known(), is_made):
        assert len({(job.case.variant, job.seed) for job in jobs}) == len(jobs)
        arrived = {"drive.success": 1.0}
        records += [
            make_record(job.case.variant, job.seed, {**arrived, "drive.path_length_m": path_m[job.case.variant]})
            for job in jobs
        ]
    oracle, alike = decisions(plan, "corridor", known())
    assert (oracle.is_told, alike.is_told) == (True, False)
    assert oracle.worlds < alike.worlds == 40
    assert sum(name in record.metrics for record in known() if record.variant == "alike") == 40


def test_a_small_difference_is_told_and_said_to_be_small(plan: Plan, make_record: MakeRecord) -> None:
    score = Metric("score", help="x", better="higher", min_difference=2.0, bounds=(0.0, 4.0))
    declared = {**plan.declared, "drive.score": score}
    wide = dataclasses.replace(plan, seeds=tuple(range(100)), metrics=("drive.score",), declared=declared)
    values = {"ica": 3.0, "worse": 0.5, "alike": 2.0}
    records = [
        make_record(variant, seed, {"drive.score": value}) for variant, value in values.items() for seed in range(100)
    ]
    worse, alike = list(stopping_texts(wide, records))[1:]
    assert worse.endswith("worlds")
    assert alike.startswith("corridor, alike: told from the base after ")
    assert alike.endswith(" worlds, by a difference smaller than what matters")
    clear = {row.case.variant: row.differences["drive.score"].is_clear for row in compare(wide, records).rows[1:]}
    assert clear == {"worse": True, "alike": False}


def test_it_ends_when_all_are_decided(plan: Plan, make_record: MakeRecord) -> None:
    records, _ = rounds_of(plan, make_record, lambda variant, _: variant == "ica")
    assert len(records) == 30
    assert [(one.worlds, one.is_told) for one in decisions(plan, "corridor", records)] == [(10, True), (10, True)]


def test_what_is_there_is_not_asked_for_and_does_not_change_the_decision(plan: Plan, make_record: MakeRecord) -> None:
    records = [
        make_record(variant, seed, {"drive.success": float(variant == "ica" and seed < 110)})
        for variant in plan.variants
        for seed in plan.seeds
    ]
    assert jobs_of_next_round(plan, records, lambda _: True) == []
    assert {one.worlds for one in decisions(plan, "corridor", records)} == {10}


def test_a_round_that_is_not_complete_decides_nothing(plan: Plan, make_record: MakeRecord) -> None:
    records, _ = rounds_of(plan, make_record, lambda variant, _: variant == "ica")
    assert [one.worlds for one in decisions(plan, "corridor", records[:-1])] == [5, 5]
    assert [one.is_told for one in decisions(plan, "corridor", records[:-1])] == [False, False]


def test_other_studies_say_nothing(plan: Plan) -> None:
    assert list(stopping_texts(dataclasses.replace(plan, until_clear=False), [])) == []


def test_a_metric_without_bounds_is_refused(plan: Plan) -> None:
    check_stopping(plan)
    with pytest.raises(UserError) as error:
        check_stopping(dataclasses.replace(plan, metrics=("drive.path_length_m",)))
    assert str(error.value) == (
        "--until-clear: 'drive.path_length_m' decides, and its stage does not declare a lowest and a highest value\n"
        "  metrics with both are drive.success; name one first in --metrics"
    )
    with pytest.raises(UserError, match="names no metric to decide by"):
        check_stopping(dataclasses.replace(plan, metrics=()))


def test_a_metric_of_frames_that_differ_is_refused(plan: Plan) -> None:
    auroc = Metric("auroc", help="Area.", better="higher", of_frames=True, bounds=(0.0, 1.0))
    cases = tuple(dataclasses.replace(case, drives_as=case.variant) for case in plan.cases)
    declared = {**plan.declared, "sight.auroc": auroc}
    own = dataclasses.replace(plan, cases=cases, declared=declared, metrics=("sight.auroc",))
    with pytest.raises(UserError, match=r"'sight\.auroc' decides, and worse meets frames of its own on corridor"):
        check_stopping(own)
    check_stopping(dataclasses.replace(own, cases=plan.cases))


def test_a_value_outside_of_its_bounds_ends_the_study(plan: Plan, make_record: MakeRecord) -> None:
    with pytest.raises(GraphnavError, match=r"corridor, alike, seed 100: drive\.success is 2, outside of its bounds 0"):
        jobs_of_next_round(plan, [make_record("alike", 100, {"drive.success": 2.0})], lambda _: False)


def test_tables_call_clear_what_the_rule_decides(plan: Plan, make_record: MakeRecord) -> None:
    lost = {"worse": 14, "alike": 6}
    records = [
        make_record(variant, seed, {"drive.success": float(seed - 100 >= lost.get(variant, 0))})
        for variant in plan.variants
        for seed in plan.seeds
    ]
    at_end = {one.case.variant: one.is_told for one in decisions(plan, "corridor", records)}
    assert at_end == {"worse": True, "alike": False}
    for until_clear, clear in ((False, {"worse", "alike"}), (True, {"worse"})):
        study = dataclasses.replace(plan, until_clear=until_clear)
        rows = compare(study, records).rows
        assert {
            row.case.variant
            for row in rows
            if "drive.success" in row.differences and row.differences["drive.success"].is_clear
        } == clear
        assert ("e-process" in table_markdown(study, compare(study, records))) == until_clear
