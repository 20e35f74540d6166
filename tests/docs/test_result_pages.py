"""The checks of the sentences in docs/results, tried on results whose values are known."""

from __future__ import annotations

from itertools import product
from pathlib import Path

import pytest
from gen_results import PAGE as PAGE_OF_RESULTS
from gen_results import placeless, problems
from result_pages.claims import Claim, claims, listed_claims, unchecked
from result_pages.expression import evaluate
from result_pages.rivals import with_rivals
from result_pages.shipped_results import ShippedResults
from result_pages.tables import with_tables

from graphnav.core.errors import UserError

HEADER = "graph,variant,role,method,condition,seed,outcome,failure,frames,sim_s,drive.success,sight.auroc"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Results of two methods: one arrives in 8 of 10 worlds, the other in none."""
    lines = [HEADER]
    for seed in range(10):
        arrives = seed < 8
        lines.append(f"bend,ica,method,ica,dim,{seed},{'goal' if arrives else 'contact'},,9,1.0,{float(arrives)},0.9")
        lines.append(f"bend,blind,baseline,blind,dim,{seed},contact,,9,1.0,0.0,")
    lines.append("bend,broken,method,broken,dim,0,failed,raised,9,1.0,,")
    (tmp_path / "small").mkdir()
    (tmp_path / "small" / "results.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")
    return tmp_path


@pytest.fixture
def results(folder: Path) -> ShippedResults:
    """Return the results of the study ``small``."""
    return ShippedResults.read("small", folder)


@pytest.mark.parametrize(
    "expression",
    [
        'arrive("bend", "ica") == 8',
        'worlds("bend", "ica") == 10',
        'outcomes("bend", "blind", "contact") == 10',
        'total("bend", "ica", "drive.success") == 8 and total("bend", "ica", "drive.success", first=5, last=8) == 3',
        'arrive("bend", "broken") == 0',
        'round(mean("bend", "ica", "sight.auroc"), 2) == 0.9',
        'difference("bend", "ica", "blind", "drive.success") == 0.8',
        'apart("bend", "ica", "blind") and not apart("bend", "ica", "ica")',
        'clear("bend", "blind") and not clear("bend", "broken")',
        'ahead("bend", "ica", "sim_s", "sight.auroc") and not ahead("bend", "ica", "sight.auroc", "sim_s")',
        'arrive("bend", "blind") < arrive("bend", "ica") <= 8',
        'arrive("bend", "ica", at="dim") - 3 == 5 and n_graphs() == 1 and n_runs() == 21',
        'low("bend", "ica", "drive.success") > 0.4 and high("bend", "ica", "drive.success") < 1',
        'graphs_below("blind") == 1 and graphs_above("blind") == 0',
        'round(low("bend", "ica", "drive.success", modulo=5), 2) == 0.46',  # five worlds, driven twice
    ],
)
def test_an_expression_that_the_results_bear_out_is_true(results: ShippedResults, expression: str) -> None:
    assert evaluate(expression, results) is True


@pytest.mark.parametrize(
    ("expression", "message"),
    [
        ('arrive("bend", "icb") == 8', "variants: ica, blind, broken"),
        ('mean("bend", "ica", "sight.au") > 0', "have no metric 'sight.au'"),
        ("__import__('os')", "is not allowed"),
        ('arrive("bend"', "cannot be read"),
        ('arrive("bend", "ica", at="bright") == 8', "have no run of"),
        ('"ica" < 3', "is not a number"),
    ],
)
def test_an_expression_that_cannot_be_evaluated_says_why(
    results: ShippedResults, expression: str, message: str
) -> None:
    with pytest.raises(ValueError, match=message.replace("(", r"\(")):
        evaluate(expression, results)


def test_several_runs_a_world_need_a_condition(results: ShippedResults) -> None:
    more = [{**row, "condition": "bright"} for row in results.rows]
    both = ShippedResults("small", (*results.rows, *more))
    assert evaluate('arrive("bend", "ica", at="bright") == 8', both) is True
    with pytest.raises(ValueError, match="name the condition"):
        evaluate('arrive("bend", "ica") == 8', both)


PAGE = """# Page

Words that state nothing.

- ICA arrives in 8 of 10 worlds,
  at `--seeds 0:10` and 0.5 degrees.
  <!-- check small: arrive("bend", "ica") == 8;
       worlds("bend", "ica") == 10; given 0.5 -->
- The blind one fails.

```
better than 5
```

| table | 7 |
"""


def test_a_statement_that_compares_needs_a_check() -> None:
    assert list(unchecked(PAGE)) == ["line 9: no check: - The blind one fails."]


def test_a_claim_that_holds_has_no_problems(results: ShippedResults) -> None:
    [claim] = claims(PAGE)
    assert claim.study == "small"
    assert claim.line == 5
    assert len(claim.expressions) == 2
    assert not list(claim.problems(results))


def test_a_claim_that_does_not_hold_is_named_with_its_value(results: ShippedResults) -> None:
    [claim] = claims(PAGE.replace("== 8", "== 9").replace("ICA arrives in 8", "ICA arrives in 9"))
    [problem] = claim.problems(results)
    assert problem == 'line 5: not true: arrive("bend", "ica") == 9 (left side: 8)'


def test_a_number_that_nothing_checks_is_named(results: ShippedResults) -> None:
    [claim] = claims(PAGE.replace("0.5 degrees", "0.6 degrees"))
    assert list(claim.problems(results)) == ["line 5: the number 0.6 is not in the check"]


LISTED = """
- says: "| dim | 8 of 10 |"
  holds:
    small:
      - arrive("bend", "ica") == 8 and worlds("bend", "ica") == 10
- says: The blind one arrives in 1.
  holds:
    small:
      - arrive("bend", "blind") == 1
"""


def test_a_list_checks_a_page_without_comments(results: ShippedResults) -> None:
    page = "| world | ica |\n|---|---|\n| dim | 8 of 10 |\n\nThe blind one\narrives in 1.\n"
    row, sentence = listed_claims(LISTED, page)
    assert list(row.problems(results)) == []
    [problem] = sentence.problems(results)
    assert problem == 'line 6: not true: arrive("bend", "blind") == 1 (left side: 0)'
    with pytest.raises(UserError, match=r"does not say: \| dim \| 8 of 10"):
        list(listed_claims(LISTED, page.replace("8 of", "9 of")))
    with pytest.raises(UserError, match=r"nothing checks the row: \| dark \| 3"):
        list(listed_claims(LISTED, page + "\n| dark | 3 |\n"))


@pytest.mark.parametrize(
    ("expression", "left"),
    [
        ('(arrive("bend", "ica") == 9 and n_graphs() == 1) or n_runs() == 1', "8"),
        ('(arrive("bend", "ica") - 1) * 2 < 3', "14"),
        ('not (clear("bend", "blind"))', "False"),
        ('not n_graphs() == 1 and mean("bend", "ica", "sight.au") > 0', "1"),
        ('not n_graphs() and mean("bend", "ica", "sight.au") > 0', "the results of 'small' have no metric"),
    ],
)
def test_a_claim_that_does_not_hold_may_have_any_form(results: ShippedResults, expression: str, left: str) -> None:
    [problem] = Claim(1, "Words.", "small", (expression,), "").problems(results)
    assert problem.startswith(f"line 1: not true: {expression} (left side: {left}")


@pytest.mark.parametrize(
    "expression",
    [
        'round(mean("bend", "ica", "sight.auroc"), 2) > 0',
        'round(mean("bend", "ica", "sight.auroc"), digits=2) > 0',
        'interval("bend", "ica", "sight.auroc", 2, at="dim") == "0.90 [0.90, 0.90]"',
    ],
)
def test_the_number_of_digits_is_not_a_result(results: ShippedResults, expression: str) -> None:
    claim = Claim(1, "It arrives in 2 of 21 worlds.", "small", (expression, "n_runs() == 21"), "")
    assert list(claim.problems(results)) == ["line 1: the number 2 is not in the check"]


def test_what_the_pages_claim_is_borne_out_by_the_results_that_ship() -> None:
    assert len(list(claims(PAGE_OF_RESULTS.read_text(encoding="utf-8")))) > 20
    assert not list(problems())


def test_a_table_is_made_from_the_results_and_noticed_when_it_is_not_fresh(folder: Path) -> None:
    page = folder / "README.md"
    text = "<!-- table small: arrive(graph, variant) -->\nold\n<!-- end of table -->\n"
    page.write_text(text, encoding="utf-8")
    assert list(problems(page, folder)) == ["the tables are not fresh; run python tools/gen_results.py"]
    made = with_tables(text, lambda name: ShippedResults.read(name, folder))
    assert "|  | bend |\n| --- | --- |\n| ica | 8 |\n| blind | 0 |\n| broken | 0 |" in made
    page.write_text(made, encoding="utf-8")
    assert not list(problems(page, folder))


def test_a_variant_is_compared_with_itself_under_another_condition(results: ShippedResults) -> None:
    def bright(row: dict[str, str]) -> dict[str, str]:
        arrives = row["variant"] == "ica" and row["seed"] in "0123"
        return {**row, "condition": "bright", "drive.success": str(float(arrives)) if row["drive.success"] else ""}

    both = ShippedResults("small", (*results.rows, *(bright(dict(row)) for row in results.rows)))
    of_both = 'at="bright", since="dim"'
    for expression in (
        'arrivals("bend", "ica") == "8 / 4"',
        f'change("bend", "ica", "drive.success", 2, {of_both}) == "-0.40 [-0.69, +0.02]"',
        f'change_of_all("ica", "drive.success", 1, {of_both}) == "-0.4 [-0.7, +0.0]"',
        f'not changes("bend", "ica", "drive.success", {of_both})',
        f'not changes_of_all("blind", "drive.success", {of_both})',
        f'unchanged("bend", "ica", {of_both}) == 6 and unchanged_of_all("blind", {of_both}) == 10',
        'arrive_of_all("ica", at="bright") == 4 and runs_of("ica", at="bright") == 10',
        f'change("bend", "ica", "drive.success", 2, {of_both}, modulo=5) == "-0.40 [-0.68, -0.12]"',
    ):
        assert evaluate(expression, both) is True, expression


@pytest.mark.parametrize(
    ("body", "header", "first"),
    [
        ("mean(graph, variant, metric); metrics sight.auroc; as AUROC; digits 2", "|  | AUROC |", "| ica | 0.90 |"),
        ("arrive(graph, variant, at=condition)", "|  | dim | bright |", "| ica | 8 | 8 |"),
        (
            'interval(graph, variant, "sight.auroc", 1, at=condition)',
            "|  | dim | bright |",
            "| ica | 0.9 [0.9, 0.9] | 0.9 [0.9, 0.9] |",
        ),
    ],
)
def test_a_table_has_a_column_a_metric_or_a_condition(
    results: ShippedResults, body: str, header: str, first: str
) -> None:
    if "condition" in body:
        more = [{**row, "condition": "bright"} for row in results.rows]
        results = ShippedResults("small", (*results.rows, *more))
    lines = with_tables(f"<!-- table small: {body} -->\n<!-- end of table -->", lambda _: results).split("\n")
    assert lines[2] == header
    assert lines[4] == first


@pytest.mark.parametrize(
    ("body", "said"),
    [
        ("arive(graph, variant)", "'arive('bend', 'ica')' is not allowed"),
        ('mean(graph, variant, "sight.au")', "have no metric 'sight.au'"),
        ("mean(graph, variant, metric); metrics sight.au", "have no metric 'sight.au'"),
        ('arrive(graph, "icb")', "variants: ica, blind, broken"),
        ('arrive(graph, variant, at="bright")', "have no run of"),
        ("arrive(graph, variant, at=condition)", "the study has no conditions"),
        ("arrive(graph, variant); digit 2", "there is no option 'digit'"),
        ("arrive(graph, variant); digits", "the option 'digits' has no value"),
        ("arrive(graph, variant); digits two", "digits are 'two', not a number"),
        ("arrive(graph, variant); as A, B", "'as' has 2 titles for 1 columns: bend"),
        ("arrive(graph, variant); metrics sight.auroc", "'metrics' is for a study of one graph"),
    ],
)
def test_a_table_with_a_typing_error_is_refused(folder: Path, body: str, said: str) -> None:
    page = folder / "README.md"
    page.write_text(f"<!-- table small: {body} -->\n<!-- end of table -->\n", encoding="utf-8")
    with pytest.raises(UserError) as error:
        list(problems(page, folder))
    assert str(error.value).startswith(f"the table small: {body}: ")
    assert said in str(error.value)


def test_a_case_that_was_not_run_or_has_no_such_metric_is_blank(results: ShippedResults) -> None:
    only_ica = [{**row, "graph": "laps"} for row in results.rows if row["variant"] == "ica"]
    both = ShippedResults("small", (*results.rows, *only_ica))
    for expression in (
        'mean(graph, variant, "sight.auroc")',
        'low(graph, variant, "sight.auroc")',
        '0.9 + difference(graph, variant, "ica", "sight.auroc")',
    ):
        made = with_tables(f"<!-- table small: {expression}; digits 1 -->\n<!-- end of table -->", lambda _: both)
        assert made.split("\n")[2:7] == [
            "|  | bend | laps |",
            "| --- | --- | --- |",
            "| ica | 0.9 | 0.9 |",
            "| blind |  |  |",
            "| broken |  |  |",
        ]


RIVALS = """# Page

<!-- section rivals -->
<!-- end of section -->
"""


def test_the_section_on_rivals_is_written_from_the_results_with_a_check_of_each_sentence(tmp_path: Path) -> None:
    variants = ("homography", "ica", "one gain", "truth", "vfh", "vfh truth")
    for study, metric, graphs in (
        ("rivals", "drive.spl", ("rivals/low", "rivals/tight")),
        ("rivals_barn", "drive.barn_metric", ("rivals/barn",)),
    ):
        lines = [HEADER.replace("sight.auroc", metric).replace("condition,", "")]
        for graph, variant, seed in product(graphs, variants, range(10)):
            arrives = variant != "ica" or graph == "rivals/tight" or seed < 2
            outcome = f"{'goal' if arrives else 'contact'},,9,1.0,{float(arrives)},{0.9 * arrives}"
            lines.append(f"{graph},{variant},method,{variant},{seed},{outcome}")
        (tmp_path / study).mkdir()
        (tmp_path / study / "results.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")

    def read(study: str) -> ShippedResults:
        return ShippedResults.read(study, tmp_path)

    page = with_tables(with_rivals(RIVALS, tmp_path), read)
    for said in (
        (
            "- **ICA** and the homography: 12 and 20 of 20 drives arrive, by arriving behind, by SPL behind. "
            "World by world: by arriving behind in `low` (2 and 10 arrive); by SPL behind in `low` (2 and 10 arrive)."
        ),
        (
            "- **`vfh`** and the path, on what the homography sees: 20 and 20 of 20 drives arrive, "
            "by arriving not told apart, by SPL not told apart. World by world: by arriving told apart in none; "
        ),
        "- **ICA** and one gain: 2 and 10 of 10 drives arrive, by arriving behind, by the challenge's metric behind.\n",
        "| ica | 2 | 10 |",
    ):
        assert said in page
    assert not list(unchecked(page))
    assert not [problem for claim in claims(page) for problem in claim.problems(read(claim.study))]
    assert with_tables(with_rivals(page, tmp_path), read) == page


def test_without_results_the_section_is_empty(tmp_path: Path) -> None:
    assert with_rivals(RIVALS.replace("-->\n<!-- end", "-->\nan old sentence\n<!-- end"), tmp_path) == RIVALS


def test_a_table_that_is_taken_over_does_not_say_where_its_study_was() -> None:
    command = "`graphnav ablate barn --seeds 3,9 -o {}barn --gallery 0`"
    assert placeless(command.format("/home/me/studies/")) == placeless(command.format("")) == command.format("")
