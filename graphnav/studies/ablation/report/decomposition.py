"""A decomposed study: sentences, table rows, and ``decompose.png``, which shows where a drive is lost."""

from __future__ import annotations

import io
import math
from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, Any

from graphnav.core.tables import Table
from graphnav.studies.ablation.plan import Plan
from graphnav.studies.ablation.report.number_format import difference_text, estimate_text, format_of, number
from graphnav.studies.ablation.results import Difference, Estimate, Losses, Swap
from graphnav.studies.ablation.study import listed

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


_HEADER = (
    "swapped for its oracle",
    "alone",
    "difference from the graph",
    "with those above",
    "difference from the row above",
)


def heading(of: Losses) -> str:
    """Return what a table or a chart shows."""
    return f"{of.metric}, {of.graph}" + (", on the oracle's drive" if of.is_common else "")


def sentences(plan: Plan, of: Losses) -> Iterator[str]:
    """Yield what was lost where, and which swaps changed nothing; or that the time limit lets nothing be concluded."""
    if of.is_cut_off:
        yield (
            f"{of.metric} on {of.graph}: every run hit the time limit before it arrived, with all oracles too, so it "
            "does not show where the drive is lost. Give the runs more time: --set run.until_s=SECONDS."
        )
        return
    last = next((swap.estimate for swap in reversed(of.cumulative) if swap.estimate is not None), None)
    reached = "" if last is None else f", {_mean(last)} with all oracles"
    yield f"{of.metric} on {of.graph} is {_mean(of.as_it_is)} as it is{reached}."
    known = [(swap, swap.gain) for swap in of.cumulative if swap.gain is not None and swap.gain.mean]
    sign = -1 if plan.better(of.metric) == "lower" else 1
    gains = [(swap, gain) for swap, gain in known if sign * gain.mean > 0]
    if gains:
        swap, gain = max(gains, key=lambda one: sign * one[1].mean)
        yield f"The largest step is that of {swap.stage}, {difference_text(gain)}{_doubt(gain)}."
    elif all(swap.is_same or swap.gain is not None for swap in of.cumulative):
        yield "No oracle improves it."


def notes(plan: Plan, found: Sequence[Losses]) -> Iterator[str]:
    """Yield how to read it: what was swapped, on which drive, and which swaps do not reach it."""
    assert plan.decomposition is not None
    swaps = ", ".join(f"{stage} for {use}" for stage, use in plan.decomposition.oracles.items())
    yield f"Swapped are {swaps}; differences are of the same worlds: in how many it was better–alike–worse."
    if any(of.is_common for of in found):
        yield (
            "What depends on the frames that a run meets is measured for all variants on one drive, that of the last "
            "oracle; everything else on each variant's own drive."
        )
    if any(plan.is_of_frames(of.metric) and not of.is_common for of in found):
        yield "No oracle could drive for all: metrics of detectors are of each variant's own frames."
    unused = dict.fromkeys((swap.stage, swap.unused) for of in found for swap in of.cumulative if not of.is_common)
    for stage, names in unused:
        if names:
            yield (
                f"With the oracle of {stage}, {listed(names)} no longer {'drives' if len(names) == 1 else 'drive'}: "
                "nothing that drives reads them, and their oracles add nothing from there on."
            )


def loss_table(of: Losses) -> Table:
    """Return what each oracle adds, alone and with those above."""
    worlds = of.as_it_is.n
    rows = [("nothing", estimate_text(of.as_it_is, worlds), "", "", "")]
    rows += [
        (alone.stage, _value(alone, worlds), _gain(alone), _value(step, worlds), _gain(step))
        for alone, step in zip(of.single, of.cumulative, strict=True)
    ]
    return Table.plain(_HEADER, rows, title=heading(of))


def _value(swap: Swap, worlds: int) -> str:
    return "" if swap.estimate is None else estimate_text(swap.estimate, worlds)


def _gain(swap: Swap) -> str:
    if swap.is_same:
        return "the same graph"
    return "" if swap.gain is None else difference_text(swap.gain)


def _doubt(gain: Difference) -> str:
    """Return what to add where the interval holds 0."""
    return "" if gain.low > 0 or gain.high < 0 else f", which {gain.n} worlds do not tell from 0"


def _mean(of: Estimate) -> str:
    return number(of.mean, format_of(of.mean, of.low, of.high))


PICTURE = "decompose.png"
_LEVEL, _GAIN, _LOSS, _INK, _QUIET = "#1f5fa8", "#2a9d8f", "#d1495b", "#15191f", "#868e99"
_WIDTH_IN, _HEIGHT_IN, _PIXELS_PER_IN = 5.4, 3.1, 150
_BAR, _ASIDE = 0.62, 0.18
_MIN_MARGIN = 0.005
"""Of the largest value shown, above and below: keeps rounding from filling a chart."""
_RING: Any = {"markersize": 5, "markerfacecolor": "white", "linewidth": 0.9}


def decomposition_picture(found: Sequence[Losses], kind: str = "png") -> bytes:
    """Return a chart for every graph (column) and metric (row) as a picture, "png" or "svg"; the same bytes each time.

    From left to right: the graph as it is, what each further oracle adds, all oracles. Rings: the graph with the oracle
    of one stage alone, with the 95 % interval of its difference from the graph as it is.
    """
    import matplotlib as mpl

    with mpl.rc_context({"font.size": 9, "svg.fonttype": "none", "svg.hashsalt": "graphnav"}):
        figure = _figure(found)
        data = io.BytesIO()
        metadata = {"Date": None} if kind == "svg" else {"Software": None}
        figure.savefig(data, format=kind, dpi=_PIXELS_PER_IN, metadata=metadata)
    return data.getvalue()


def _figure(found: Sequence[Losses]) -> Figure:
    from matplotlib.figure import Figure

    graphs = list(dict.fromkeys(of.graph for of in found))
    metrics = list(dict.fromkeys(of.metric for of in found))
    figure = Figure((_WIDTH_IN * len(graphs), _HEIGHT_IN * len(metrics) + 0.4), layout="constrained")
    grid = figure.subplots(len(metrics), len(graphs), squeeze=False, sharey="row")
    for axes in grid.flat:
        axes.set_axis_off()
    for row, metric in zip(grid, metrics, strict=True):
        shown = [
            value
            for of in found
            if of.metric == metric
            for value in _draw(row[graphs.index(of.graph)], of, has_ticks=of.graph == graphs[0])
        ]
        row[0].set_ylim(*_limits(shown))
    handles = _legend_handles()
    columns = len(handles) if len(graphs) > 1 else 2
    figure.legend(handles=handles, loc="outside lower center", ncols=columns, frameon=False, fontsize=8)
    return figure


def _limits(shown: Sequence[float]) -> tuple[float, float]:
    low, high = min(shown), max(shown)
    margin = max(0.08 * (high - low), _MIN_MARGIN * max(abs(high), abs(low)))
    return low - margin, high + margin


def _draw(axes: Axes, of: Losses, *, has_ticks: bool) -> list[float]:
    """Draw the steps of one graph by one metric; return the values that they cover."""
    axes.set_axis_on()
    axes.spines[["top", "right"]].set_visible(False)
    axes.set_title(heading(of), loc="left", fontsize=10, color=_INK)
    means = [of.as_it_is.mean, *(None if swap.estimate is None else swap.estimate.mean for swap in of.cumulative)]
    is_lower = of.better == "lower"
    levels = {0: of.as_it_is.mean}
    for place, (before, after) in enumerate(pairwise(means), start=1):
        if after is None:
            continue
        if before is None:
            levels[place] = after
            continue
        axes.bar(place, after - before, _BAR, bottom=before, color=_LOSS if (after < before) != is_lower else _GAIN)
        axes.hlines(before, place - 1 + _BAR / 2, place + _BAR / 2, colors=_QUIET, linewidth=0.8)
    labels = ["as it is", *(f"+ {swap.stage}" for swap in of.cumulative)]
    steps = zip(of.cumulative, pairwise(means), strict=True)
    values = [f"{of.as_it_is.mean:.3f}", *(_step_text(swap, *ends) for swap, ends in steps)]
    if means[-1] is not None:
        levels[len(means)] = means[-1]
        labels.append("all oracles")
        values.append(f"{means[-1]:.3f}")
    for place, mean in levels.items():
        axes.hlines(mean, place - _BAR / 2, place + _BAR / 2, colors=_LEVEL, linewidth=4)
    axes.set_xticks(range(len(labels)), [f"{name}\n{value}" for name, value in zip(labels, values, strict=True)])
    axes.tick_params(axis="x", length=0)
    axes.tick_params(axis="y", labelleft=has_ticks)
    axes.set_xlim(-0.6, len(of.cumulative) + 1.6)
    axes.grid(axis="y", color=_QUIET, alpha=0.25, linewidth=0.6)
    axes.set_axisbelow(True)
    return [*(mean for mean in means if mean is not None), *_draw_single(axes, of)]


def _step_text(swap: Swap, before: float | None, after: float | None) -> str:
    """Return the change of a step; its mean where the one before is not known."""
    if after is None:
        return "not known"
    if before is None:
        return f"{after:.3f}"
    return "same graph" if swap.is_same else number(after - before, ".3f", sign="+")


def _draw_single(axes: Axes, of: Losses) -> list[float]:
    """Draw the graph with one oracle alone; return the values that it covers."""
    found = [(place, swap) for place, swap in enumerate(of.single, start=1) if swap.estimate is not None]
    means = [swap.estimate.mean for _, swap in found if swap.estimate is not None]
    bounds = [_bounds(of, swap, mean) for (_, swap), mean in zip(found, means, strict=True)]
    below = [mean - low for mean, (low, _) in zip(means, bounds, strict=True)]
    above = [high - mean for mean, (_, high) in zip(means, bounds, strict=True)]
    axes.errorbar([place + _ASIDE for place, _ in found], means, yerr=[below, above], fmt="o", color=_INK, **_RING)
    return [bound for both in bounds for bound in both]


def _bounds(of: Losses, swap: Swap, mean: float) -> tuple[float, float]:
    """Return the interval of a swap's difference, from the graph as it is; it ends at the metric's bounds."""
    if swap.gain is None or not math.isfinite(swap.gain.low):
        return mean, mean
    low, high = of.as_it_is.mean + swap.gain.low, of.as_it_is.mean + swap.gain.high
    if of.span is not None:
        low, high = max(low, of.span[0]), min(high, of.span[1])
    return min(low, mean), max(high, mean)


def _legend_handles() -> list[Artist]:
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    return [
        Line2D([], [], color=_LEVEL, linewidth=4, label="mean"),
        Patch(color=_GAIN, label="one more oracle: better"),
        Patch(color=_LOSS, label="one more oracle: worse"),
        Line2D([], [], marker="o", color=_INK, label="this oracle alone, 95 % interval of its difference", **_RING),
    ]
