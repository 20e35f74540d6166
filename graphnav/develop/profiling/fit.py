"""Measure a graph with larger and larger pictures: what fits on this machine, or on a share of it."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from contextlib import nullcontext
from dataclasses import dataclass, replace
from pathlib import Path
from textwrap import indent
from typing import NamedTuple

from graphnav import Graph, GraphnavError, Image
from graphnav.core.api import with_run_options
from graphnav.core.graph import Node
from graphnav.core.machine import CpuQuota
from graphnav.core.stage import params_of
from graphnav.develop.parameters import Clock
from graphnav.develop.profiling.measurement import NothingMeasuredError, measure

SIZES = ((160, 120), (320, 240), (640, 480), (1280, 960))
"""Columns and rows."""
_N_TICKS = 60


class Rate(NamedTuple):
    """The rate at which 99 of 100 ticks end in time, with pictures of a size (columns, rows; None: the graph's own).

    ``failure``: why the graph does not run with it, in place of a rate.
    """

    size: tuple[int, int] | None
    hz: float
    failure: str = ""


@dataclass(frozen=True)
class Fit:
    """The sizes measured, from small to large up to the first that misses ``wanted_hz``, the rate of the graph.

    ``percent``: of one core, None for all that the machine has.
    """

    wanted_hz: float
    rates: tuple[Rate, ...]
    percent: float | None = None

    def __str__(self) -> str:
        where = "this machine" if self.percent is None else f"{self.percent:g} % of a core of this machine"
        runs = [rate for rate in self.rates if not rate.failure]
        measured = ", ".join(f"{_size(rate)}: {rate.hz:.3g} Hz" for rate in runs if rate.size)
        fitting = [rate for rate in runs if rate.hz >= self.wanted_hz]
        if self.rates[0].size is None and runs:
            verb = "fits" if fitting else "does not fit"
            line = f"{verb} on {where}: {self.wanted_hz:.3g} Hz (measured {runs[0].hz:.3g} Hz; one size of pictures)"
        elif fitting:
            line = f"fits on {where}: {self.wanted_hz:.3g} Hz up to {_size(fitting[-1])} (measured {measured})"
        else:
            line = f"does not fit on {where}: {self.wanted_hz:.3g} Hz at any size" + (
                f" ({measured})" if measured else ""
            )
        failed = (indent(f"{_size(rate)} does not run: {rate.failure}", "  ") for rate in self.rates if rate.failure)
        return "\n".join([line, *failed])


def measure_fit(
    graph: Graph, wanted_hz: float, clock: Clock, percent: float | None, notice: Callable[[str], None]
) -> Fit:
    """Run a graph briefly with each size of pictures, until one is too large for its rate, ``wanted_hz``.

    ``percent``: on this share of one core. Pictures are those of the first source that has a size; a graph without
    one is measured as it is. The world that a graph simulates is part of its ticks.

    Raises
    ------
    UserError
        The processor cannot be limited.
    """
    source = next((node for node in graph.sources if _has_size(node)), None)
    until_s = _N_TICKS / wanted_hz
    if graph.run.until_s is not None:
        until_s = min(until_s, graph.run.until_s)
    brief = with_run_options(graph, {"until_s": until_s})
    rates: list[Rate] = []
    for size in SIZES if source is not None else (None,):
        sized = brief if source is None or size is None else brief.with_nodes([_with_size(source, size)])
        with nullcontext() if percent is None else CpuQuota(percent) as quota:
            rates.append(_rate(sized, size, clock, quota, notice))
        if rates[-1].failure or rates[-1].hz < wanted_hz:
            break
    return Fit(wanted_hz, tuple(rates), percent)


def _rate(
    graph: Graph, size: tuple[int, int] | None, clock: Clock, quota: CpuQuota | None, notice: Callable[[str], None]
) -> Rate:
    try:
        stages = graph.make_stages()
        with tempfile.TemporaryDirectory(prefix="graphnav-") as scratch:
            if quota is not None:
                quota.join()
            found = measure(graph, stages, Path(scratch), functions=False, clock=clock, notice=notice)
    except GraphnavError as error:
        if isinstance(error, NothingMeasuredError) and error.outcome == "stopped":
            raise
        return Rate(size, 0.0, str(error))
    if found.failure:
        return Rate(size, 0.0, found.failure)
    return Rate(size, 1e3 / found.tick_p99_ms)


def _has_size(node: Node) -> bool:
    shows = any(channel.message is Image for channel in node.outputs.values())
    return shows and "size" in params_of(node.stage_class)


def _with_size(node: Node, size: tuple[int, int]) -> Node:
    setting = replace(node.settings["size"], value=size)
    return replace(node, settings={**node.settings, "size": setting})


def _size(rate: Rate) -> str:
    return "its own size" if rate.size is None else "{}x{}".format(*rate.size)
