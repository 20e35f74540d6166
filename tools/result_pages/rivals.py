"""The section on rivals with equal knowledge, written from the results of the study ``rivals`` once they ship.

Between ``<!-- section rivals -->`` and ``<!-- end of section -->`` stands nothing as long as there are none. Every
sentence gets its check, as sentences written by hand have it; tables are filled in by `tables`.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from pathlib import Path

from result_pages.functions import apart, arrive, difference, worlds
from result_pages.shipped_results import FILE, RESULTS, ShippedResults

STUDY = "rivals"
BASE, TRUTH, ICA, ONE_GAIN = "homography", "truth", "ica", "one gain"
DETECTORS = ("one gain", "residual", "affine", "appearance", "learned", "all ground")
PLANNERS = ("vfh", "dwa", "gap")
METRICS = {"drive.success": "arriving", "drive.spl": "SPL"}
_SECTION = re.compile(r"(?P<begin><!-- section rivals -->\n).*?(?P<end><!-- end of section -->)", re.DOTALL)


def with_rivals(markdown: str, folder: Path = RESULTS) -> str:
    """Return a page with the section written again; empty where the results do not ship."""
    text = ""
    if (folder / STUDY / FILE).is_file():
        text = "\n".join(["", *_section(ShippedResults.read(STUDY, folder)), "", ""])
    return _SECTION.sub(lambda found: f"{found['begin']}{text}{found['end']}", markdown)


def _section(results: ShippedResults) -> Iterator[str]:
    yield "## Rivals with equal knowledge"
    yield ""
    yield from _about(results)
    for title, expression in (
        ("Drives that arrive:", "arrive(graph, variant)"),
        ("SPL, the mean of all drives, 0 for one that failed:", 'mean(graph, variant, "drive.spl"); digits 2'),
    ):
        yield title
        yield f"<!-- check {STUDY}: given 0; n_graphs() == {len(results.graphs)} -->"
        yield ""
        yield f"<!-- table {STUDY}: {expression} -->"
        yield "<!-- end of table -->"
        yield ""
    yield "**What it says of ICA**, with the same map, path, control and guard, and no odometry for any of them:"
    yield f"<!-- check {STUDY}: n_graphs() == {len(results.graphs)} -->"
    yield ""
    for other, name in ((BASE, "the homography"), (ONE_GAIN, "one gain"), (TRUTH, "the true obstacles")):
        yield from _compared(results, ICA, "ICA", other, name)
    yield ""
    yield "**What a detector is worth**, each beside the homography:"
    yield f"<!-- check {STUDY}: n_graphs() == {len(results.graphs)} -->"
    yield ""
    for variant in (*DETECTORS, TRUTH):
        yield from _compared(results, variant, f"`{variant}`", BASE, "the homography")
    yield ""
    yield "**What a planner is worth**, each beside the path on the same map:"
    yield f"<!-- check {STUDY}: n_graphs() == {len(results.graphs)} -->"
    yield ""
    for planner in PLANNERS:
        yield from _compared(results, planner, f"`{planner}`", BASE, "the path, on what the homography sees")
        yield from _compared(
            results, f"{planner} truth", f"`{planner} truth`", TRUTH, "the path, on the true obstacles"
        )


def _about(results: ShippedResults) -> Iterator[str]:
    """Yield how the study was made."""
    seeds = sorted({int(row["seed"]) for row in results.rows})
    runs = {graph: worlds(results, graph, BASE) for graph in results.graphs}
    few = [graph for graph, count in runs.items() if count < max(runs.values())]
    but = "".join(f", {runs[graph]} of `{_short(graph)}`" for graph in few)
    yield (
        f"`graphnav ablate rivals --seeds {seeds[0]}:{seeds[-1] + 1}`, [all metrics](rivals/table.md), "
        f"[every run](rivals/results.csv): {max(runs.values())} seeds a world{but}. "
        "[How it is fair](../explanation/navigate.md#rivals-with-equal-knowledge)."
    )
    checks = "; ".join(f'worlds("{graph}", "{BASE}") == {count}' for graph, count in runs.items())
    yield f"<!-- check {STUDY}: given {seeds[0]} {seeds[-1] + 1}; {checks} -->"
    yield ""


def _compared(results: ShippedResults, a: str, name: str, b: str, other: str) -> Iterator[str]:
    """Yield a list item: where two variants are told apart, by arriving and by SPL."""
    if {a, b} - set(results.variants):
        return
    parts, checks = [], [f"n_graphs() == {len(results.graphs)}"]
    for metric, word in METRICS.items():
        told = [graph for graph in results.graphs if apart(results, graph, a, b, metric)]
        better = [graph for graph in told if difference(results, graph, a, b, metric) > 0]
        worse = [graph for graph in told if graph not in better]
        checks.append(f'graphs_apart("{a}", "{b}", "{metric}") == {len(told)}')
        checks += [f'difference("{graph}", "{a}", "{b}", "{metric}") > 0' for graph in better]
        checks += [f'difference("{graph}", "{a}", "{b}", "{metric}") < 0' for graph in worse]
        where = [f"{sign} in {_listed(results, of, a, b)}" for sign, of in (("ahead", better), ("behind", worse)) if of]
        parts.append(f"by {word} {', '.join(where) if where else 'told apart in none'}")
        checks += [
            f'arrive("{graph}", "{variant}") == {arrive(results, graph, variant)}'
            for graph in told
            for variant in (a, b)
        ]
    yield f"- **{name}** and {other}, in {len(results.graphs)} worlds: {'; '.join(parts)}."
    yield f"  <!-- check {STUDY}: {'; '.join(dict.fromkeys(checks))} -->"


def _listed(results: ShippedResults, graphs: Sequence[str], a: str, b: str) -> str:
    return ", ".join(
        f"`{_short(graph)}` ({arrive(results, graph, a)} and {arrive(results, graph, b)} arrive)" for graph in graphs
    )


def _short(graph: str) -> str:
    return graph.rpartition("/")[2]
