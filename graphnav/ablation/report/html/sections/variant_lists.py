"""The variants by verdict: better than the base, not distinguishable from it, worse."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

from graphnav.ablation.report.html.markup import Html, esc, tag
from graphnav.ablation.report.html.number_text import counted, estimated, means_text
from graphnav.ablation.report.html.sections.forest_plot import missing_reason
from graphnav.ablation.report.html.sections.headline import Found, name, verdicts
from graphnav.ablation.report.html.study_results import StudyResults
from graphnav.ablation.report.html.verdict import Verdict
from graphnav.ablation.results import Row

_MAX_NAMED = 6
_MAX_CHECKS = 3
_MAX_INTERVALS = 8
"""Of more differences the means stand alone; the chart and the tables have the intervals."""


def variants_by_verdict(study: StudyResults, metric: str, found: Found) -> Html:
    """Return three lists of methods, each with its difference from the base on the graphs where that holds."""
    titles: dict[Verdict, str] = {
        "better": "Better than the base",
        "unclear": f"No difference that {counted(study.n_seeds, 'world')} can tell",
        "worse": "Worse than the base",
        "different": "Different from the base",
        "unknown": "Not known",
    }
    is_brief = len(found) > _MAX_INTERVALS
    rows = []
    for verdict, title in titles.items():
        entries = list(_entries(study, metric, found, verdict, is_brief=is_brief))
        if not entries and verdict in {"different", "unknown"}:
            continue
        said = _some(entries) if entries else tag("span", "none", class_="quiet")
        rows.append(tag("dt", tag("span", class_=f"sign {verdict}"), esc(title)) + tag("dd", said))
    rows = [*rows, *_unbeaten(study, metric)] if found else list(_unbeaten(study, metric))
    return tag("dl", *rows, class_="sides") if rows else ""


def _unbeaten(study: StudyResults, metric: str) -> Iterator[Html]:
    """Yield the baselines that the base does not clearly beat: what they lack may not be needed."""
    found = verdicts(study, metric, "baseline")
    kept: Found = {key: ("unclear", row) for key, (verdict, row) in found.items() if verdict in {"better", "unclear"}}
    entries = list(_entries(study, metric, kept, "unclear", is_brief=len(kept) > _MAX_INTERVALS))
    if entries:
        title = tag("dt", tag("span", class_="sign baseline"), "Baselines that the base does not beat")
        yield title + tag("dd", _some(entries))


def _some(entries: Sequence[Html]) -> Html:
    more = f" and {len(entries) - _MAX_NAMED} more" if len(entries) > _MAX_NAMED else ""
    return "; ".join(entries[:_MAX_NAMED]) + more


def _entries(study: StudyResults, metric: str, found: Found, verdict: Verdict, *, is_brief: bool) -> Iterator[Html]:
    graphs = study.plan.graphs
    for variant in dict.fromkeys(variant for variant, _ in found):
        here = {g: found[variant, g][1] for g in graphs if (variant, g) in found and found[variant, g][0] == verdict}
        if not here:
            continue
        if is_brief:
            said = _brief(here.values(), metric) + ("" if len(here) == len(graphs) else f" on {esc(', '.join(here))}")
        else:
            said = ", ".join(
                _change(row, metric) + (f" on {esc(graph)}" if len(graphs) > 1 else "") for graph, row in here.items()
            )
        yield f"{name(variant)} {tag('span', said, class_='quiet')}"


def _change(row: Row, metric: str) -> Html:
    found = row.differences.get(metric)
    if found is None:
        return esc(missing_reason(row)) if metric not in row.estimates else "no common world"
    return estimated(found.mean, found.low, found.high, signed=True)


def _brief(rows: Iterable[Row], metric: str) -> Html:
    found = [row.differences[metric].mean for row in rows if metric in row.differences]
    return means_text(found, signed=True) if found else "no common world"


def reference_values(study: StudyResults, metric: str) -> Html:
    """Return what baselines and oracles came to: they say whether worlds and scores can be trusted."""
    said = []
    for role in ("baseline", "oracle"):
        cases = [case for case in study.plan.cases if case.role == role and not case.same_as]
        variants = list(dict.fromkeys(case.variant for case in cases))
        if len(variants) > _MAX_CHECKS:
            said.append(f"{len(variants)} {role}s {_range(study, variants, metric)}")
        else:
            said += [f"{role} {name(variant)} {_range(study, [variant], metric)}" for variant in variants]
    return tag("p", f"For scale, {esc(metric)} over all graphs: ", "; ".join(said), ".", class_="note") if said else ""


def _range(study: StudyResults, variants: Sequence[str], metric: str) -> Html:
    """Return the least and the greatest mean of variants over all graphs."""
    every = [found.mean for g in study.plan.graphs for v in variants if (found := study.estimate(g, v, metric))]
    return means_text(every) if every else "not known"
