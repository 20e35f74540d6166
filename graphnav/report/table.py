"""What happened in a run, as a table for the terminal."""

from __future__ import annotations

from rich import box
from rich.console import Console, Group
from rich.measure import Measurement
from rich.table import Table
from rich.text import Text

from graphnav.clock import MAX_LATE_S
from graphnav.runner.summary import Summary

_COLOURS = {"goal": "green", "end": "green", "contact": "red", "failed": "red", "timeout": "yellow"}
_MOST_COLS = 1000
"""Tables are as wide as they need: a narrow terminal wraps them, for a figure that is cut would be a wrong one."""


def print_summary(console: Console, summary: Summary) -> None:
    """Print how the run ended, what each stage did and what was scored."""
    console.print(_headline(summary))
    tables = [_stages(summary)]
    if any(summary.scores.values()):
        tables.append(_scores(summary))
    for table in tables:
        table.width = Measurement.get(console, console.options.update(width=_MOST_COLS), table).maximum
    console.print(Group(*tables), soft_wrap=True)


def _headline(summary: Summary) -> Text:
    rate = summary.frames / summary.wall_s if summary.wall_s else 0.0
    text = Text(summary.outcome, style=f"bold {_COLOURS.get(summary.outcome, 'default')}")
    text.append(f" after {summary.sim_s:.1f} s: {summary.frames} ticks, seed {summary.seed}", style="default not bold")
    text.append(f", {summary.wall_s:.1f} s of wall time ({rate:.0f} ticks/s)", style="default not bold")
    if summary.behind_s > MAX_LATE_S:
        text.append(f", {summary.behind_s:.1f} s behind the wall clock", style="yellow not bold")
    return text


def _stages(summary: Summary) -> Table:
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    table.add_column("stage")
    table.add_column("use")
    has_deadlines = any(did.missed is not None for did in summary.stages.values())
    for name in ("steps", "p50 ms", "p99 ms", "dropped", *(["missed"] if has_deadlines else [])):
        table.add_column(name, justify="right")
    for name, did in summary.stages.items():
        cells = [name, did.use, str(did.steps), f"{did.p50_ms:.2f}", f"{did.p99_ms:.2f}", str(did.dropped)]
        missed = "" if did.missed is None else str(did.missed)
        table.add_row(*cells, *([missed] if has_deadlines else []))
    return table


def _scores(summary: Summary) -> Table:
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    table.add_column("score")
    table.add_column("figure")
    table.add_column("value", justify="right")
    for stage, figures in summary.scores.items():
        for place, (figure, value) in enumerate(figures.items()):
            table.add_row("" if place else stage, figure, f"{value:.4g}")
    return table
