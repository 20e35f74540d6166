"""The sentences below a table: how to read it, and how to reproduce it."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence

from graphnav import UNDEFINED
from graphnav.studies.ablation.plan import Plan
from graphnav.studies.ablation.report.number_format import APPROXIMATE
from graphnav.studies.ablation.results import ALPHA, EXACT_BELOW, Comparison, Row, min_worlds, shown_metrics
from graphnav.studies.ablation.study import MetricExpression

INTERVALS = (
    "Intervals are 95 %, over worlds: Student's t. For metrics that are 0 or 1 in every run they are Wilson's score "
    "interval for the mean and Bonett and Price's adjusted Wald interval for the difference, which have a width also "
    f"where all worlds agree. {APPROXIMATE} marks those of single means over fewer than {EXACT_BELOW} worlds: they are "
    "approximate where the metric is skewed."
)
TESTS = (
    f"p is the chance of such a difference where none is, by the exact sign-flip test below {EXACT_BELOW} worlds, "
    "Student's t test from there on, and McNemar's exact test for metrics that are 0 or 1; it is adjusted for all "
    "variants of a table by Holm's procedure."
)
_ANYTIME = (
    "p is the chance of such evidence for a difference where none is, however often it was looked at (betting "
    "e-process), because the results decided the number of worlds; it is adjusted for all variants of a table by "
    "Holm's procedure."
)
UNTESTED = (
    "Other metrics are not tested and never bold: their intervals hold each for itself, and where nothing differs one "
    "in twenty still leaves out 0."
)
OWN_FRAMES = "own frames"
"""In place of a difference of what depends on the frames met, between variants that drive differently."""


def tests(plan: Plan) -> str:
    """Return what p is."""
    return _ANYTIME if plan.until_clear else TESTS


def deciding(plan: Plan, metric: str | None, called: str = "bold") -> str:
    """Return when a difference of the metric that decides is bold, or called something else."""
    if metric is None:
        return f"No run has a metric, so no difference is {called}."
    smallest = plan.min_difference(metric)
    conditions = [f"p is at most {ALPHA:g}", "the interval leaves out 0"]
    conditions += [f"the mean is at least {smallest:g}, the smallest difference that matters"] if smallest else []
    *first, last = conditions
    return f"{metric} decides: its differences are {called} where {', '.join(first)} and {last}."


def too_few_worlds(plan: Plan, comparison: Comparison) -> str:
    """Return how many worlds it takes to separate the variants of the largest table, empty if all have as many.

    Empty also where the results decide the number of worlds.
    """
    if plan.until_clear:
        return ""
    tables = {
        (plan.n_worlds(row.case), difference.significance.family)
        for row in comparison.rows
        for difference in row.differences.values()
        if difference.significance is not None
    }
    few = [(min_worlds(family), family, n) for n, family in tables if n < min_worlds(family)]
    if not few:
        return ""
    needed, family, n = max(few)
    who = f"{family} variants from the base" if family > 1 else "a variant from the base"
    worlds = "1 world" if n == 1 else f"{n} worlds"
    return f"{worlds} cannot separate {who}, even if all speak for one side: that takes {needed}."


def counting(plan: Plan, columns: Iterable[str]) -> str:
    """Return how failed runs count for the metrics of some columns, as declared; plain text."""
    names = dict.fromkeys(name for column in columns for name in MetricExpression.parse(column).operands)
    declared = {name: plan.metric(name).if_failed for name in names}
    with_value = [f"{name} {value:g}" for name, value in declared.items() if not isinstance(value, str)]
    undefined = [name for name, value in declared.items() if value == UNDEFINED]
    sentences = [
        f"A run in which a stage failed counts as {', '.join(with_value)}; its other metrics do not count."
        if with_value
        else "The metrics of a run in which a stage failed do not count."
    ]
    if undefined:
        sentences.append(f"{', '.join(undefined)}: only of drives that arrived.")
    sentences.append("A world in which a metric is undefined does not count for it; n is how many did if not all do.")
    return " ".join(sentences)


def legend(plan: Plan, comparison: Comparison) -> tuple[str, ...]:
    """Return the sentences below a study's table, plain text."""
    where = f", under the same {' and '.join(plan.within)}" if plan.within else ""
    reading = (
        "Each cell is the mean over worlds with its interval; ↑ higher is better, ↓ lower. Differences are from the "
        f"base, {plan.base}, in the same worlds{where}: the mean with its interval, in how many worlds it was "
        f"better–alike–worse. {deciding(plan, comparison.primary)}"
    )
    if any(plan.better(metric) == "neither" for metric in shown_metrics(plan, comparison)):
        reading += " Of metrics without an arrow neither is better: in how many worlds it was higher–alike–lower."
    few = too_few_worlds(plan, comparison)
    sentences = [reading, *([few] if few else []), INTERVALS, tests(plan), UNTESTED]
    sentences.append(counting(plan, shown_metrics(plan, comparison)))
    if any(row.own_frames.intersection(shown_metrics(plan, comparison)) for row in comparison.rows):
        sentences.append(
            f"{OWN_FRAMES.capitalize()}: the variant drives differently from the base and met other frames; what "
            "depends on these is not compared. Compare detectors on one drive: in a graph that measures them on it, or "
            "with --decompose."
        )
    roles = {row.case.role for row in comparison.rows}
    if "baseline" in roles:
        sentences.append("A baseline is what every method has to beat; where it does well, the worlds test nothing.")
    if "oracle" in roles:
        sentences.append("An oracle sees the truth: it shows what its part leaves to gain, and is not a bound.")
    return tuple(sentences)


def origin(plan: Plan) -> tuple[tuple[str, str], ...]:
    """Return what makes the table again: name and value."""
    versions = ", ".join(f"{name} {version}" for name, version in plan.versions.items())
    facts = [("command", plan.command), ("seeds", worlds_of_graphs(plan)), ("versions", versions)]
    return tuple((name, value) for name, value in facts if value)


def marks(row: Row) -> tuple[str, ...]:
    """Return the marks beside the name of a case."""
    found = ["base"] if row.case.is_base else []
    if row.case.role != "method":
        found.append(row.case.role)
    return tuple(found)


def same_graphs(rows: Iterable[Row]) -> Iterator[str]:
    """Yield which variants are the same graph, of which the tables show the first."""
    others: dict[str, list[str]] = {}
    for row in rows:
        if row.case.same_as:
            others.setdefault(row.case.same_as, []).append(row.case.variant)
    for first, variants in others.items():
        yield f"{first} is the same graph as {', '.join(variants)}"


def outcome_counts(outcomes: Mapping[str, int]) -> str:
    """Return the number of runs by outcome, the most frequent first."""
    ordered = sorted(outcomes.items(), key=lambda item: (-item[1], item[0]))
    return ", ".join(f"{outcome} {times}" for outcome, times in ordered)


def worlds_text(row: Row) -> str:
    """Return the number of runs, and of how many if some are still to be made."""
    return f"{row.runs} of {row.runs + row.pending}" if row.pending else str(row.runs)


def worlds_of_graphs(plan: Plan) -> str:
    """Return the seeds in short, and which graphs have only the first of them."""
    fewer = {case.source: plan.n_worlds(case) for case in plan.cases if plan.n_worlds(case) < len(plan.seeds)}
    return "; ".join([seeds_text(plan.seeds), *(f"{source}: the first {number}" for source, number in fewer.items())])


def seeds_text(seeds: Sequence[int]) -> str:
    """Return seeds in short: ``1000 to 1049 (50)``; ranges and single seeds between commas."""
    runs: list[list[int]] = []
    for seed in sorted(seeds):
        if runs and seed == runs[-1][1] + 1:
            runs[-1][1] = seed
        else:
            runs.append([seed, seed])
    texts = (
        f"{first} to {last}" if last > first + 1 else ", ".join(map(str, range(first, last + 1)))
        for first, last in runs
    )
    return f"{', '.join(texts)} ({len(seeds)})"
