"""The answer in a sentence, derived from the verdicts alone, and the variants by verdict."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

from markupsafe import Markup

from graphnav import Role
from graphnav.studies.ablation.report.html.forest_plot import NO_COMMON_WORLD, missing_reason
from graphnav.studies.ablation.report.html.rendering import counted, estimate_text, estimated, means_text, rendered
from graphnav.studies.ablation.report.html.study_results import StudyResults, Verdict, verdict_of
from graphnav.studies.ablation.report.legend import OWN_FRAMES
from graphnav.studies.ablation.results import Row

Found = Mapping[tuple[str, str], tuple[Verdict, Row]]
"""Verdicts and rows by variant and graph."""

_MAX_NAMES = 3


def verdicts(study: StudyResults, metric: str, role: Role = "method") -> Found:
    """Return the verdicts of a metric on all variants of a role that have runs of their own, but the base."""
    better = study.plan.better(metric)
    return {
        (row.case.variant, graph): (verdict_of(row, metric, better), row)
        for graph in study.plan.graphs
        for row in study.own_rows(graph)
        if row.case.role == role and not row.case.is_base
    }


@dataclass(frozen=True)
class _Clause:
    """A statement on some variants, the first of which are named; on none where the text says all."""

    text: str
    variants: Sequence[str] = ()
    n_more: int = 0


@dataclass(frozen=True)
class _Rival:
    """The value of one rival and its difference from the base; ``missing``: why that is not known."""

    variant: str
    where: str
    missing: str = ""
    value: str = ""
    change: str = ""
    words: str = ""


def headline(study: StudyResults, metric: str, found: Found) -> Markup:
    """Return what the base does and whether anything does better."""
    variants = list(dict.fromkeys(variant for variant, _ in found))
    is_pair = len(variants) == 1
    return rendered(
        "headline.html",
        metric=metric,
        base=study.plan.base,
        rivals=[_rival(study, metric, verdict, row) for verdict, row in found.values()] if is_pair else [],
        base_values=_everywhere(study, metric),
        clauses=_clauses(study, found, variants),
    )


def _clauses(study: StudyResults, found: Found, rivals: Sequence[str]) -> list[_Clause]:
    """Return who is better where, most places first, then who is only worse, then who is not compared anywhere."""
    untested = [rival for rival in rivals if _verdicts(found, rival) <= {"untested"}]
    compared = len(rivals) - len(untested)
    left_out = [_statement(untested, f"not compared: {OWN_FRAMES}")] if untested else []
    if all(verdict in {"unknown", "untested"} for verdict, _ in found.values()):
        return [
            *([_Clause(f"There are too few worlds to tell the {compared} others apart")] if compared else []),
            *left_out,
        ]
    counts = {rival: _counts(found, rival) for rival in rivals}
    leading = sorted((rival for rival in rivals if counts[rival].better), key=lambda rival: -counts[rival].better)
    alike = {text: [r for r in leading if _text(study, counts[r]) == text] for text in _texts(study, counts, leading)}
    clauses = [_statement(variants, text) for text, variants in alike.items()]
    if rivals and not clauses:
        clauses.append(
            _Clause("None that is compared is better" if untested else f"None of the {compared} others is better")
        )
    trailing = [rival for rival in rivals if counts[rival].worse and not counts[rival].better]
    if len(trailing) > _MAX_NAMES:
        where = f" on some {_places(study)}" if len(study.plan.graphs) > 1 else ""
        is_all = len(trailing) == len(rivals)
        clauses.append(_Clause(f"{'all' if is_all else f'{len(trailing)} of {len(rivals)}'} are worse{where}"))
        return [*clauses, *left_out]
    return [*clauses, *(_statement([rival], _text(study, counts[rival])) for rival in trailing), *left_out]


def _verdicts(found: Found, variant: str) -> set[Verdict]:
    return {verdict for (called, _), (verdict, _) in found.items() if called == variant}


@dataclass(frozen=True)
class _Counts:
    """In how many places a variant is better than the base, and worse."""

    better: int
    worse: int


def _counts(found: Found, variant: str) -> _Counts:
    sides = [verdict for (called, _), (verdict, _) in found.items() if called == variant]
    return _Counts(sides.count("better"), sides.count("worse"))


def _texts(study: StudyResults, counts: Mapping[str, _Counts], variants: Sequence[str]) -> list[str]:
    return list(dict.fromkeys(_text(study, counts[variant]) for variant in variants))


def _text(study: StudyResults, counts: _Counts) -> str:
    """Return on how many graphs or conditions a variant is better or worse; the word alone where there is but one."""
    sides = {word: n for word, n in (("better", counts.better), ("worse", counts.worse)) if n}
    places = len(study.plan.graphs)
    if places == 1:
        return next(iter(sides))
    if list(sides.values()) == [places]:
        return f"{next(iter(sides))} everywhere"
    return f"{' and '.join(f'{word} on {n}' for word, n in sides.items())} of {places} {_places(study)}"


def _statement(variants: Sequence[str], text: str) -> _Clause:
    verb = "is" if len(variants) == 1 else "are"
    return _Clause(f"{verb} {text}", variants[:_MAX_NAMES], max(len(variants) - _MAX_NAMES, 0))


def _rival(study: StudyResults, metric: str, verdict: Verdict, row: Row) -> _Rival:
    where = f" on {row.case.graph}" if len(study.plan.graphs) > 1 else ""
    estimate, difference = row.estimates.get(metric), row.differences.get(metric)
    if estimate is None:
        return _Rival(row.case.variant, where, missing_reason(row))
    if difference is None:
        why = f"not compared: {OWN_FRAMES}" if verdict == "untested" else NO_COMMON_WORLD
        return _Rival(row.case.variant, where, f"{metric} {estimate_text(estimate)}, {why}")
    words = {
        "better": "better than the base",
        "worse": "worse than the base",
        "different": "different from the base",
        "small": "smaller than what matters",
        "unclear": f"no difference that {counted(difference.n, 'world')} can tell",
    }.get(verdict, f"{counted(difference.n, 'world')} cannot tell")
    value = estimate_text(estimate)
    change = estimated(difference.mean, difference.low, difference.high, signed=True)
    return _Rival(row.case.variant, where, "", value, change, words)


def _everywhere(study: StudyResults, metric: str) -> str:
    """Return the base's value on each graph, or the range where there are many graphs."""
    graphs, base = study.plan.graphs, study.plan.base
    found = {graph: of for graph in graphs if (of := study.estimate(graph, base, metric)) is not None}
    if len(found) > _MAX_NAMES:
        return f"{means_text([of.mean for of in found.values()])} on {len(found)} {_places(study)}"
    values = [estimate_text(of) + (f" on {graph}" if len(graphs) > 1 else "") for graph, of in found.items()]
    return ", ".join(values) or "in no run yet"


def _places(study: StudyResults) -> str:
    """Return what tells the tables of a study apart."""
    plan = study.plan
    return "graphs" if not plan.within else "conditions" if len(plan.sources) == 1 else "graphs and conditions"


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
