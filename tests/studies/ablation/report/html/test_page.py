"""The report is one file that needs nothing else, whatever the study is like."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from graphnav.core.catalog import Catalog
from graphnav.core.graph import Graph, resolved_yaml
from graphnav.core.stage import Role
from graphnav.studies.ablation.plan.plan import Plan
from graphnav.studies.ablation.report.markdown import table_markdown
from graphnav.studies.ablation.results import compare
from graphnav.studies.ablation.results.records import Record
from graphnav.studies.ablation.stopping import pending_runs

from .example_study import CLEARANCE, SUCCESS, Page, plan_of, record_of, records_of, report

ROLES: dict[str, Role] = {"ica": "method", "affine": "method", "bad": "method", "prior": "baseline", "truth": "oracle"}
SHARES = {"ica": 0.9, "affine": 0.85, "bad": 0.1, "prior": 0.0, "truth": 1.0}


def page(plan: Plan, records: list[Record], folder: Path, catalog: Catalog | None = None) -> Page:
    text = report(plan, records, folder, catalog)
    found = Page(text)
    assert [url for url in found.loads if not url.startswith(("data:", "#"))] == []
    assert all(url[1:] in found.ids for url in found.loads if url.startswith("#"))
    assert "@import" not in text
    assert re.findall(r"url\(", text) == []
    assert len(text) < 10_000_000
    return found


def test_it_holds_every_variant_and_figure_with_controls_and_oracles_marked(tmp_path: Path) -> None:
    plan = plan_of(ROLES, graphs=("corridor", "pillars"))
    found = page(plan, records_of(plan, SHARES), tmp_path)
    for word in (*ROLES, *plan.metrics, *plan.graphs, "baseline", "oracle", plan.command, plan.about, "0 to 19"):
        assert word in found.text
    assert "finished: 200 runs" in found.text


def test_a_study_that_its_results_stopped_is_finished_with_the_runs_that_it_has(tmp_path: Path) -> None:
    made = plan_of({"ica": "method", "affine": "method"}, seeds=range(40), metrics=(SUCCESS,))
    plan = replace(made, until_clear=True)
    records = [one for one in records_of(plan, {"ica": 1.0, "affine": 0.0}) if one.seed < 10]
    text = page(plan, records, tmp_path).text
    assert "finished: 20 runs" in text
    assert "not finished" not in text
    assert "10 of 40" not in text + table_markdown(plan, compare(plan, records, pending_runs(plan, records)))
    text = page(plan, records[:-1], tmp_path).text
    assert "not finished: so far 19 runs, 1 more in the next round" in text
    assert "9 of 10" in text


def test_the_answer_says_what_the_worlds_can_tell_and_no_more(tmp_path: Path) -> None:
    plan = plan_of(ROLES)
    text = page(plan, records_of(plan, SHARES), tmp_path).text
    assert "None of the 2 others is better; bad is worse." in text
    answer = text[text.index("Better than the base") : text.index("For scale")]
    assert "Better than the base none No difference that 20 worlds can tell affine −0.05 [" in answer
    assert "Worse than the base bad −0.80 [" in answer
    assert "baseline prior 0.00; oracle truth 1.00" in text


def test_many_graphs_and_methods_are_told_in_short(tmp_path: Path) -> None:
    plan = plan_of(ROLES, graphs=tuple(f"graph_{number}" for number in range(7)))
    text = page(plan, records_of(plan, SHARES), tmp_path).text
    assert "ica has drive.success 0.90 on 7 graphs." in text
    assert "Worse than the base bad −0.80 For scale" in text
    some = [r for r in records_of(plan, SHARES) if r.variant == "affine" and r.graph < "graph_4"]
    better = [replace(r, metrics={**r.metrics, SUCCESS: 1.0}) for r in some]
    worse = [replace(r, metrics={**r.metrics, SUCCESS: 0.3}) for r in records_of(plan, SHARES) if r.variant == "ica"]
    text = page(plan, [*better, *worse], tmp_path).text
    assert "affine is better on 4 of 7 graphs." in text
    assert "Better than the base affine +0.70 on 4 of 7" in text


def test_on_how_many_graphs_a_variant_is_better_is_told(tmp_path: Path) -> None:
    plan = plan_of({"ica": "method", "affine": "method", "bad": "method"}, graphs=("bend", "hall", "door", "room"))
    records = [
        *(r for r in records_of(plan, {"ica": 0.5, "affine": 0.5, "bad": 0.0}) if r.graph in ("bend", "hall")),
        *(r for r in records_of(plan, {"ica": 0.5, "affine": 1.0, "bad": 0.0}) if r.graph == "door"),
        *(r for r in records_of(plan, {"ica": 1.0, "affine": 0.0, "bad": 0.0}) if r.graph == "room"),
    ]
    text = page(plan, records, tmp_path).text
    assert "affine is better on 1 and worse on 1 of 4 graphs; bad is worse everywhere." in text
    assert "No difference that 20 worlds can tell affine 0.00 [" in text


def test_conditions_have_tables_of_their_own_and_lines_run_across_them(tmp_path: Path) -> None:
    speeds = [f"{number} m/s" for number in range(1, 5)]
    crossed = plan_of(ROLES, graphs=[f"corridor, {speed}" for speed in speeds])
    cases = tuple(
        replace(case, source="corridor", labels={**case.labels, "speed": case.graph.partition(", ")[2]})
        for case in crossed.cases
    )
    plan = replace(crossed, cases=cases, axes={**crossed.axes, "speed": tuple(speeds)}, within=("speed",))
    found = page(plan, records_of(plan, SHARES), tmp_path)
    assert "ica has drive.success 0.90 on 4 conditions." in found.text
    assert "graphs corridor compared under the same speed" in found.text
    assert all(graph in found.text for graph in plan.graphs)
    chart = found.text.partition("decides")[2].partition("corridor, 1 m/s")[0]
    assert all(f"{variant}: " in chart and f" at {number}" in chart for variant in ROLES for number in range(1, 5))


def test_a_baseline_that_is_as_good_as_the_base_is_on_the_first_screen(tmp_path: Path) -> None:
    plan = plan_of(ROLES)
    text = page(plan, records_of(plan, {**SHARES, "prior": 0.9}), tmp_path).text
    assert "Baselines that the base does not beat prior 0.00 [" in text
    assert "base does not beat" not in page(plan, records_of(plan, SHARES), tmp_path).text


def test_one_rival_gets_a_sentence(tmp_path: Path) -> None:
    plan = plan_of({"ica": "method", "affine": "method"})
    text = page(plan, records_of(plan, SHARES), tmp_path).text
    assert "affine : drive.success 0.85 [" in text
    assert "against ica — no difference that 20 worlds can tell." in text


def test_one_that_is_better_is_named(tmp_path: Path) -> None:
    plan = plan_of({"bad": "method", "ica": "method", "affine": "method"})
    text = page(plan, records_of(plan, SHARES), tmp_path).text
    assert "ica and affine are better." in text


def test_less_can_be_better(tmp_path: Path) -> None:
    plan = plan_of(
        {"bad": "method", "ica": "method", "affine": "method"}, metrics=["drive.collision"], lower=["drive.collision"]
    )
    records = [
        record_of(case, seed, "goal", drive__collision=float(seed >= SHARES[case.variant] * 20))
        for case in plan.cases
        for seed in plan.seeds
    ]
    assert "ica and affine are better." in page(plan, records, tmp_path).text


def test_what_people_wrote_is_text_and_no_markup(tmp_path: Path) -> None:
    evil = "<script>alert(1)</script>&amp;\"'"
    plan = plan_of({"ica": "method", evil: "method", "x" * 300: "method"}, graphs=("<b>corridor</b>",))
    plan = Plan(**{**vars(plan), "about": f"Why {evil}?", "command": f"graphnav ablate '{evil}'"})
    records = [record_of(case, seed, "failed") for case in plan.cases for seed in plan.seeds]
    found = page(plan, records, tmp_path)
    assert f"Why {evil}?" in found.text
    assert "it broke <down>" in found.text


def test_a_study_that_goes_on_says_so_far(tmp_path: Path) -> None:
    plan = plan_of(ROLES)
    records = [record for record in records_of(plan, SHARES) if record.seed < 7 and record.variant != "bad"]
    text = page(plan, records, tmp_path).text
    assert "not finished: so far 28 of 100 runs" in text
    assert "7 of 20" in text
    assert "no run yet" in text


def test_a_study_without_runs_has_no_answer(tmp_path: Path) -> None:
    text = page(plan_of(ROLES), [], tmp_path).text
    assert "No run is there yet, so there is no answer." in text


def test_a_single_variant_is_told_without_rivals(tmp_path: Path) -> None:
    plan = plan_of({"ica": "method"})
    text = page(plan, records_of(plan, SHARES), tmp_path).text
    assert "ica has drive.success 0.90 [" in text
    assert "Worse than the base" not in text


def test_one_world_has_no_intervals(tmp_path: Path) -> None:
    plan = plan_of(ROLES, seeds=[3])
    assert "1 world cannot separate 4 variants from the base" in page(plan, records_of(plan, SHARES), tmp_path).text


def test_few_worlds_are_said_to_be_few(tmp_path: Path) -> None:
    plan = plan_of(ROLES, seeds=[3, 4])
    assert "2 worlds cannot separate 4 variants from the base" in page(plan, records_of(plan, SHARES), tmp_path).text


def test_runs_without_scores_have_a_report(tmp_path: Path) -> None:
    plan = plan_of({"ica": "method", "affine": "method"}, metrics=())
    records = [record_of(case, seed, "end") for case in plan.cases for seed in plan.seeds]
    assert "no metric" in page(plan, records, tmp_path).text


def test_a_variant_that_always_fails_is_a_row_with_its_reason(tmp_path: Path) -> None:
    plan = plan_of({"ica": "method", "broken": "method", "affine": "method"}, metrics=(CLEARANCE,))
    records = [r for r in records_of(plan, {**SHARES, "broken": 0}) if r.variant != "broken"]
    records += [record_of(plan.case("corridor", "broken"), seed, "failed") for seed in plan.seeds]
    text = page(plan, records, tmp_path).text
    assert "20 runs failed: plane: it broke <down>" in text
    assert "failed in all of 20 worlds" in text


def test_variants_that_are_the_same_graph_say_of_which(tmp_path: Path) -> None:
    plan = plan_of({"ica": "method", "twin": "method", "affine": "method"}, same_as={"twin": "ica"})
    text = page(plan, records_of(plan, SHARES), tmp_path).text
    assert "the same graph as ica" in text
    assert "finished: 40 runs" in text
    assert "1 of 3 cases are the same graph as another" in text


def test_hundreds_of_variants_keep_the_charts_readable(tmp_path: Path) -> None:
    names: dict[str, Role] = {f"v{number}": "method" for number in range(200)}
    plan = plan_of(names, seeds=range(6))
    records = records_of(plan, {name: (number % 7) / 7 for number, name in enumerate(names)})
    found = page(plan, records, tmp_path)
    assert "176 more are in the tables" in found.text
    assert all(f"v{number} " in found.text for number in range(200))


def test_values_that_are_no_numbers_do_not_reach_the_page(tmp_path: Path) -> None:
    plan = plan_of({"ica": "method", "affine": "method"}, metrics=(CLEARANCE,), seeds=range(6))
    records = [
        record_of(case, seed, "goal", **({"drive__min_clearance_m": 0.3} if seed == 0 else {}))
        for case in plan.cases
        for seed in plan.seeds
    ]
    text = page(plan, records, tmp_path).text
    assert "in 1" in text
    assert not re.search(r"\b(nan|inf)\b", text)


def test_the_same_study_gives_the_same_bytes(tmp_path: Path) -> None:
    plan = plan_of(ROLES)
    for name in ("one", "two"):
        (tmp_path / name).mkdir()
        report(plan, records_of(plan, SHARES), tmp_path / name)
    assert (tmp_path / "one" / "report.html").read_bytes() == (tmp_path / "two" / "report.html").read_bytes()


def test_the_graph_is_drawn_with_swapped_stages_marked(
    tmp_path: Path, toys: Catalog, load: Callable[..., Graph]
) -> None:
    three: dict[str, Role] = {"ica": "method", "affine": "method", "prior": "baseline"}
    plan = plan_of(three, graph_yaml=resolved_yaml(load()))
    text = report(plan, records_of(plan, SHARES), tmp_path, toys)
    Page(text)
    assert text.count('class="mark" x=') == 1
    assert "2 rivals" in text
    assert "toy.ica; swapped for toy.affine, toy.prior" in text


def test_a_graph_whose_plugin_is_gone_is_no_obstacle(tmp_path: Path) -> None:
    plan = plan_of(ROLES, graph_yaml="stages: {flow: {use: gone.away}}\n")
    text = page(plan, records_of(plan, SHARES), tmp_path).text
    assert "It cannot be drawn here: graph.yaml" in text


@pytest.mark.parametrize("missing", ["logs", "pictures"])
def test_what_was_pruned_is_a_note(tmp_path: Path, missing: str) -> None:
    plan = plan_of(ROLES)
    text = page(plan, records_of(plan, SHARES), tmp_path).text
    notes = {"logs": "the logs are gone", "pictures": "runs failed; none is drawn"}
    assert notes[missing] in text


def test_success_is_not_shown_twice(tmp_path: Path) -> None:
    plan = plan_of(ROLES)
    text = report(plan, records_of(plan, SHARES), tmp_path)
    assert text.count(f'aria-label="{SUCCESS} of every variant"') == 1
    assert text.count(f'aria-label="{CLEARANCE} of every variant"') == 1
