"""Sentences and table rows of a decomposed study."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from graphnav.studies.ablation.plan import Plan
from graphnav.studies.ablation.report.number_format import difference_text, estimate_text, format_of, number
from graphnav.studies.ablation.results import Difference, Estimate, Losses, Swap
from graphnav.studies.ablation.study import listed

HEADER = (
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


def rows(of: Losses) -> Iterator[tuple[str, ...]]:
    """Yield the cells of a table, below `HEADER`."""
    worlds = of.as_it_is.n
    yield "nothing", estimate_text(of.as_it_is, worlds), "", "", ""
    for alone, step in zip(of.single, of.cumulative, strict=True):
        yield alone.stage, _value(alone, worlds), _gain(alone), _value(step, worlds), _gain(step)


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
