"""The variants by verdict: better than the base, not distinguishable from it, worse."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

from markupsafe import Markup

from graphnav.core.stage import Role
from graphnav.studies.ablation.report.html.number_text import counted, estimate_text, estimated, means_text
from graphnav.studies.ablation.report.html.render import rendered
from graphnav.studies.ablation.report.html.sections.forest_plot import NO_COMMON_WORLD, missing_reason
from graphnav.studies.ablation.report.html.sections.headline import Found, verdicts
from graphnav.studies.ablation.report.html.study_results import StudyResults
from graphnav.studies.ablation.report.html.verdict import Verdict
from graphnav.studies.ablation.report.legend import OWN_FRAMES
from graphnav.studies.ablation.results import Row

_MAX_NAMED = 6
_MAX_CHECKS = 3
_MAX_PLACES = 3
_MAX_INTERVALS = 8
"""Of more differences the means stand alone; the chart and the tables have the intervals."""
_UNBEATEN: frozenset[Verdict] = frozenset({"better", "small", "unclear"})
_ROLES: tuple[Role, ...] = ("baseline", "oracle")


@dataclass(frozen=True)
class _Entry:
    """A variant with its differences from the base."""

    variant: str
    text: str


@dataclass(frozen=True)
class _Variants:
    """The variants of one verdict, the first of them listed."""

    sign: str
    title: str
    entries: Sequence[_Entry]
    n_more: int


@dataclass(frozen=True)
class _Reference:
    """The range of one baseline or oracle, or of many."""

    title: str
    variant: str
    range: str


def variants_by_verdict(study: StudyResults, metric: str, found: Found) -> Markup:
    """Return lists of methods, each with its difference from the base on the graphs where that holds.

    Those that are not compared have their values instead.
    """
    titles: dict[Verdict, str] = {
        "better": "Better than the base",
        "small": "Smaller than what matters",
        "unclear": f"No difference that {counted(study.n_seeds, 'world')} can tell",
        "worse": "Worse than the base",
        "different": "Different from the base",
        "unknown": "Not known",
        "untested": f"Not compared: {OWN_FRAMES}",
    }
    is_brief = len(found) > _MAX_INTERVALS
    lists = []
    for verdict, title in titles.items() if found else ():
        entries = list(_entries(study, metric, found, verdict, is_brief=is_brief))
        if entries or verdict in {"better", "unclear", "worse"}:
            lists.append(_first(verdict, title, entries))
    return rendered("verdicts.html", lists=[*lists, *_unbeaten(study, metric)])


def _unbeaten(study: StudyResults, metric: str) -> Iterator[_Variants]:
    """Yield the baselines that the base does not clearly beat: what they lack may not be needed."""
    found = verdicts(study, metric, "baseline")
    kept: Found = {key: ("unclear", row) for key, (verdict, row) in found.items() if verdict in _UNBEATEN}
    entries = list(_entries(study, metric, kept, "unclear", is_brief=len(kept) > _MAX_INTERVALS))
    if entries:
        yield _first("baseline", "Baselines that the base does not beat", entries)


def _first(sign: str, title: str, entries: Sequence[_Entry]) -> _Variants:
    return _Variants(sign, title, entries[:_MAX_NAMED], max(len(entries) - _MAX_NAMED, 0))


def _entries(study: StudyResults, metric: str, found: Found, verdict: Verdict, *, is_brief: bool) -> Iterator[_Entry]:
    graphs = study.plan.graphs
    for variant in dict.fromkeys(variant for variant, _ in found):
        here = {g: found[variant, g][1] for g in graphs if (variant, g) in found and found[variant, g][0] == verdict}
        if not here:
            continue
        if is_brief:
            text = f"{_brief(here.values(), metric)}{_where(list(here), len(graphs))}"
        else:
            text = ", ".join(
                _change(row, metric) + (f" on {graph}" if len(graphs) > 1 else "") for graph, row in here.items()
            )
        yield _Entry(variant, text)


def _where(graphs: Sequence[str], n_all: int) -> str:
    """Return the places by name, or how many of all they are; empty for all."""
    if len(graphs) == n_all:
        return ""
    return f" on {', '.join(graphs)}" if len(graphs) <= _MAX_PLACES else f" on {len(graphs)} of {n_all}"


def _change(row: Row, metric: str) -> str:
    found, estimate = row.differences.get(metric), row.estimates.get(metric)
    if estimate is None:
        return missing_reason(row)
    if found is None:
        return estimate_text(estimate) if metric in row.own_frames else NO_COMMON_WORLD
    return estimated(found.mean, found.low, found.high, signed=True)


def _brief(rows: Iterable[Row], metric: str) -> str:
    some = list(rows)
    found = [row.differences[metric].mean for row in some if metric in row.differences]
    if found:
        return means_text(found, signed=True)
    own = [row.estimates[metric].mean for row in some if metric in row.estimates and metric in row.own_frames]
    return means_text(own) if own else NO_COMMON_WORLD


def reference_values(study: StudyResults, metric: str) -> Markup:
    """Return the metric of baselines and oracles: it shows whether worlds and scores can be trusted."""
    references = []
    for role in _ROLES:
        cases = [case for case in study.plan.cases if case.role == role and not case.same_as]
        variants = list(dict.fromkeys(case.variant for case in cases))
        if len(variants) > _MAX_CHECKS:
            references.append(_Reference(f"{len(variants)} {role}s", "", _range(study, variants, metric)))
        else:
            references += [_Reference(role, variant, _range(study, [variant], metric)) for variant in variants]
    return rendered("references.html", metric=metric, references=references)


def _range(study: StudyResults, variants: Sequence[str], metric: str) -> str:
    """Return the range of the means of variants over all graphs."""
    every = [found.mean for g in study.plan.graphs for v in variants if (found := study.estimate(g, v, metric))]
    return means_text(every) if every else "not known"
