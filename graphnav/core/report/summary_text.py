"""The summary of a run for the terminal: the verdict and a few numbers, or tables of all."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from types import MappingProxyType
from typing import Any

from rich.text import Text

from graphnav.core.machine.console import Console
from graphnav.core.runner.recording.summary import Summary
from graphnav.core.runner.simulated_clock import MAX_LATE_S
from graphnav.core.stage import Better, Metric
from graphnav.core.tables import Column, Table, print_fitted

_COLOURS = {"goal": "green", "end": "green", "contact": "red", "failed": "red", "timeout": "yellow"}
_ENDINGS = {
    "goal": "goal reached",
    "contact": "contact with an obstacle",
    "timeout": "time limit reached",
    "end": "end of the input reached",
}
_WHERE_BETTER: dict[Better, str] = {"higher": "higher", "lower": "lower", "neither": ""}
_N_SHOWN = 5
"""Metrics that are shown beside the verdict; summary.json has them all."""

Declared = Mapping[str, Mapping[str, Metric]]
"""The declared metrics of each stage of a graph, by name."""
NONE_DECLARED: Declared = MappingProxyType({})


def print_summary(
    console: Console, summary: Summary, declared: Declared = NONE_DECLARED, *, is_verbose: bool = False
) -> None:
    """Print how the run ended, its first metrics, and what came in and went out live; ``declared``: of the graph.

    ``is_verbose``: all metrics, those that are undefined in this run by their names, and what each stage did.
    """
    console.print(_ending(summary))
    tables = [_stages(summary)] if is_verbose else []
    tables += _outside(summary.live or {})
    if is_verbose and any(summary.scores.values()):
        tables.append(_scores(summary, declared))
    elif shown := _first_metrics(summary, declared):
        tables.append(_few(shown))
    for table in tables:
        print_fitted(console, table)
    undefined = _undefined(summary, declared) if is_verbose else []
    if undefined:
        console.print(Text(f"undefined in this run: {', '.join(undefined)}"), soft_wrap=True)
    for name, did in summary.stages.items() if not is_verbose else ():
        if did.missed:
            console.print(Text(f"{name} missed its deadline in {did.missed} of {did.steps} steps", style="yellow"))
    console.print(_amount(summary))


def _first_metrics(summary: Summary, declared: Declared) -> list[tuple[str, float]]:
    """Return the labels and values of a few metrics: the key ones, then those that judge, in the stages' order.

    What is 0 or 1 and no key metric, as whether the run touched anything, is told by the verdict.
    """
    key, judging, rest = list[tuple[str, float]](), list[tuple[str, float]](), list[tuple[str, float]]()
    for stage, values in summary.scores.items():
        for name, value in values.items():
            metric = declared.get(stage, {}).get(name)
            entry = f"{stage}.{metric.label if metric else name}", value
            if metric is not None and metric.is_key:
                key.append(entry)
            elif metric is not None and metric.better != "neither" and (metric.unit or metric.limits is None):
                judging.append(entry)
            else:
                rest.append(entry)
    return [*key, *judging, *rest][:_N_SHOWN]


def _undefined(summary: Summary, declared: Declared) -> list[str]:
    """Return the names of the metrics that the stages with a summary declare and do not have."""
    return [
        f"{stage}.{name}"
        for stage, values in summary.scores.items()
        for name, metric in declared.get(stage, {}).items()
        if name not in values and not metric.relative_to
    ]


def _few(metrics: Sequence[tuple[str, float]]) -> Table:
    columns = (Column(""), Column("", "value", "right"))
    return Table(columns, [(name, f"{value:.4g}") for name, value in metrics])


def _amount(summary: Summary) -> Text:
    rate = summary.frames / summary.wall_s if summary.wall_s else 0.0
    counted = "ticks" if summary.live is None else "firings"
    text = Text(f"{summary.frames} {counted}, seed {summary.seed}")
    text.append(f", {summary.wall_s:.1f} s of wall time ({rate:.0f} {counted}/s)")
    if summary.behind_s > MAX_LATE_S:
        text.append(f", {summary.behind_s:.1f} s behind the wall clock", style="yellow")
    return text


def _ending(summary: Summary) -> Text:
    outcome = summary.outcome
    text = Text(_ENDINGS.get(outcome, outcome), style=f"bold {_COLOURS.get(outcome, 'default')}")
    text.append(f" after {summary.sim_s:.1f} s", style="default not bold")
    return text


def _stages(summary: Summary) -> Table:
    has_deadlines = any(did.missed is not None for did in summary.stages.values())
    numbers = ("steps", "p50 ms", "p99 ms", "dropped", *(["missed"] if has_deadlines else []))
    rows = []
    for name, did in summary.stages.items():
        cells = (name, did.use, did.steps, f"{did.p50_ms:.2f}", f"{did.p99_ms:.2f}", did.dropped)
        rows.append((*cells, *([did.missed] if has_deadlines else [])))
    return _right_table(("stage", "use"), numbers, rows)


def _outside(live: Mapping[str, Any]) -> Iterator[Table]:
    """Yield tables of the inputs and outputs of a live run, if it has any."""
    if live.get("inputs"):
        rows = list[tuple[object, ...]]()
        for one in live["inputs"]:
            rejected = ", ".join(f"{n} {why}" for why, n in zip(one["reasons"], one["rejected"], strict=True))
            rows.append((one["name"], one["channel"], one["accepted"], one["lost"], rejected or "0"))
        yield _right_table(("input", "channel"), ("accepted", "lost", "rejected"), rows)
    if live.get("outputs"):
        rows = []
        for one in live["outputs"]:
            measured = [f"{one[f'latency_{what}_ms']:.1f}" for what in ("p50", "p99", "max")]
            times = measured if one["latency_max_ms"] else [""] * 3  # stops that a timer sent have no picture
            rows.append((one["name"], one["channel"], one["sent"], *times))
        yield _right_table(("output", "channel"), ("sent", "latency p50 ms", "p99 ms", "max ms"), rows)


def _right_table(names: Sequence[str], numbers: Sequence[str], rows: Sequence[Sequence[object]]) -> Table:
    """Return a table whose names stay where it is too wide, and whose other columns are numbers."""
    return Table.plain((*names, *numbers), rows, right=numbers, n_fixed=len(names))


def _scores(summary: Summary, declared: Declared = NONE_DECLARED) -> Table:
    rows = []
    for stage, values in summary.scores.items():
        for place, (name, value) in enumerate(values.items()):
            metric = declared.get(stage, {}).get(name)
            label, better = (metric.label, _WHERE_BETTER[metric.better]) if metric else (name, "")
            rows.append(("" if place else stage, label, f"{value:.4g}", better))
    return Table.plain(("score", "metric", "value", "better"), rows, right=("value",), n_fixed=2)
