"""The section on rivals with equal knowledge, written from the results of ``rivals`` and ``rivals_barn`` that ship.

Between ``<!-- section rivals -->`` and ``<!-- end of section -->`` stands nothing as long as there are none. Every
sentence gets its check, as sentences written by hand have it; tables are filled in by `tables`.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from pathlib import Path

from result_pages.functions import (
    apart_of_all,
    arrive,
    arrive_of_all,
    difference,
    difference_of_all,
    runs_of,
    where_apart,
    worlds,
)
from result_pages.shipped_results import FILE, RESULTS, ShippedResults

BASE, TRUTH, ICA, ONE_GAIN = "homography", "truth", "ica", "one gain"
DETECTORS = ("one gain", "residual", "affine", "appearance", "learned", "all ground")
PLANNERS = ("vfh", "dwa", "gap")
N_BARN_WORLDS = 300
"""A seed beyond drives one of them again, with other noise."""
MIN_DRIVES = 6
"""Fewer cannot be told apart at 0.05, whatever they are."""
SUITE, BARN = "rivals", "rivals_barn"
METRICS = {
    SUITE: {"drive.success": "arriving", "drive.spl": "SPL"},
    BARN: {"drive.success": "arriving", "drive.barn_metric": "the challenge's metric"},
}
"""By study: what is compared, and the words for it."""
TABLES = {
    SUITE: (
        ("Drives that arrive:", "arrive(graph, variant)"),
        ("SPL, the mean of all drives, 0 for one that failed:", 'mean(graph, variant, "drive.spl"); digits 2'),
    ),
    BARN: (
        ("Drives that arrive:", "arrive(graph, variant)"),
        ("The challenge's metric, the mean of all drives:", 'mean(graph, variant, "drive.barn_metric"); digits 3'),
    ),
}
_SECTION = re.compile(r"(?P<begin><!-- section rivals -->\n).*?(?P<end><!-- end of section -->)", re.DOTALL)


def with_rivals(markdown: str, folder: Path = RESULTS) -> str:
    """Return a page with the section written again; empty where the results do not ship."""
    lines = []
    for study in METRICS:
        if (folder / study / FILE).is_file():
            lines += ["", *_section(study, ShippedResults.read(study, folder)), ""]
    text = "\n".join([*lines, ""]) if lines else ""
    return _SECTION.sub(lambda found: f"{found['begin']}{text}{found['end']}", markdown)


def _section(study: str, results: ShippedResults) -> Iterator[str]:
    n = f"n_graphs() == {len(results.graphs)}"
    yield "## Rivals with equal knowledge" if study == SUITE else "### The same rivals in worlds of BARN"
    yield ""
    yield from _about(study, results)
    for title, expression in TABLES[study]:
        yield title
        yield f"<!-- check {study}: given 0; {n} -->"
        yield ""
        yield f"<!-- table {study}: {expression} -->"
        yield "<!-- end of table -->"
        yield ""
    yield "**What it says of ICA**, with the same map, path, control and guard, and no odometry for any of them:"
    yield f"<!-- check {study}: {n} -->"
    yield ""
    for other, name in ((BASE, "the homography"), (ONE_GAIN, "one gain"), (TRUTH, "the true obstacles")):
        yield from _compared(study, results, ICA, "ICA", other, name)
    yield ""
    yield "**What a detector is worth**, each beside the homography:"
    yield f"<!-- check {study}: {n} -->"
    yield ""
    for variant in (*DETECTORS, TRUTH):
        yield from _compared(study, results, variant, f"`{variant}`", BASE, "the homography")
    yield ""
    yield "**What a planner is worth**, each beside the path on the same map:"
    yield f"<!-- check {study}: {n} -->"
    yield ""
    seen, true = "the path, on what the homography sees", "the path, on the true obstacles"
    for planner in PLANNERS:
        yield from _compared(study, results, planner, f"`{planner}`", BASE, seen)
        yield from _compared(study, results, f"{planner} truth", f"`{planner} truth`", TRUTH, true)


def _about(study: str, results: ShippedResults) -> Iterator[str]:
    """Yield how the study was made."""
    seeds = sorted({int(row["seed"]) for row in results.rows})
    runs = {graph: worlds(results, graph, BASE) for graph in results.graphs}
    few = [graph for graph, count in runs.items() if count < max(runs.values())]
    but = "".join(f", {runs[graph]} of `{_short(graph)}`" for graph in few)
    is_range = seeds == list(range(seeds[0], seeds[-1] + 1))
    written = f"{seeds[0]}:{seeds[-1] + 1}" if is_range else ",".join(map(str, seeds))
    what = f"{max(runs.values())} seeds a world{but}" if study == SUITE else _barn_drives(seeds)
    yield (
        f"`graphnav ablate {study} --seeds {written}`, [all metrics]({study}/table.md), "
        f"[every run]({study}/results.csv): {what}. "
        "[How it is fair](../explanation/navigate.md#rivals-with-equal-knowledge)."
    )
    if len(results.graphs) > 1 and not _are_alone(results):
        yield "So few drives tell nothing apart in a single world; methods are compared over the drives of all worlds."
    given = " ".join(dict.fromkeys([*written.replace(":", ",").split(","), *re.findall(r"(\d+) drives", what)]))
    checks = "; ".join(f'worlds("{graph}", "{BASE}") == {count}' for graph, count in runs.items())
    yield f"<!-- check {study}: given {given}; {checks} -->"
    yield ""


def _barn_drives(seeds: Sequence[int]) -> str:
    """Return how many worlds of BARN some seeds drive, and how often each."""
    n_worlds = len({seed % N_BARN_WORLDS for seed in seeds})
    each = len(seeds) // n_worlds
    return f"{n_worlds} worlds, {'one drive' if each == 1 else f'{each} drives'} each"


def _compared(study: str, results: ShippedResults, a: str, name: str, b: str, other: str) -> Iterator[str]:
    """Yield a list item: where two variants are told apart, over all drives and in single worlds."""
    if {a, b} - set(results.variants):
        return
    said, checks = _compared_over_all(study, results, a, b)
    parts = []
    for metric, word in METRICS[study].items() if _are_alone(results) else ():
        told = where_apart(results, a, b, metric)
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
    alone = f" World by world: {'; '.join(parts)}." if parts else ""
    yield f"- **{name}** and {other}: {said}.{alone}"
    yield f"  <!-- check {study}: {'; '.join(dict.fromkeys(checks))} -->"


def _are_alone(results: ShippedResults) -> bool:
    """Whether single worlds have enough drives to tell methods apart, and there are several."""
    return len(results.graphs) > 1 and max(worlds(results, graph, BASE) for graph in results.graphs) >= MIN_DRIVES


def _compared_over_all(study: str, results: ShippedResults, a: str, b: str) -> tuple[str, list[str]]:
    """Return how two variants compare over the drives in all worlds, and the checks of that."""
    n = runs_of(results, a)
    arrived = arrive_of_all(results, a), arrive_of_all(results, b)
    checks = [f"n_graphs() == {len(results.graphs)}", f'runs_of("{a}") == {n}']
    checks += [f'arrive_of_all("{one}") == {count}' for one, count in zip((a, b), arrived, strict=True)]
    words = []
    for metric, word in METRICS[study].items():
        if not apart_of_all(results, a, b, metric):
            checks.append(f'not apart_of_all("{a}", "{b}", "{metric}")')
            words.append(f"by {word} not told apart")
            continue
        is_ahead = difference_of_all(results, a, b, metric) > 0
        checks += [
            f'apart_of_all("{a}", "{b}", "{metric}")',
            f'difference_of_all("{a}", "{b}", "{metric}") {">" if is_ahead else "<"} 0',
        ]
        words.append(f"by {word} {'ahead' if is_ahead else 'behind'}")
    return f"{arrived[0]} and {arrived[1]} of {n} drives arrive, {', '.join(words)}", checks


def _listed(results: ShippedResults, graphs: Sequence[str], a: str, b: str) -> str:
    return ", ".join(
        f"`{_short(graph)}` ({arrive(results, graph, a)} and {arrive(results, graph, b)} arrive)" for graph in graphs
    )


def _short(graph: str) -> str:
    return graph.rpartition("/")[2]
