"""Turn what a profiled run measured into a profile; and count the threads that libraries used."""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Iterator

from threadpoolctl import threadpool_info

from graphnav import Graph
from graphnav.core.runner import Summary
from graphnav.develop.parameters import Clock
from graphnav.develop.profiling.flame import Node
from graphnav.develop.profiling.profile import ChannelTime, Instruments, Profile, StageTime
from graphnav.develop.profiling.step_functions import Function
from graphnav.develop.profiling.stopwatch import Part, Span
from graphnav.develop.profiling.tick_spans import TickSpans

_OF_A_CHANNEL = (Part.ENCODE, Part.DELIVER, Part.DECODE, Part.LOG, Part.TAP)
_REMAINDERS = (Part.TICK, Part.STAGE)


def profile_of(graph: Graph, spans: TickSpans, summary: Summary, clock: Clock, reading_us: float) -> Profile:
    """Return the profile of a run with at least one timed tick.

    ``reading_us``: the cost of a clock reading of the instruments. Nearly all of them are made between the other
    parts, so that it is taken from what the runner seems to need.
    """
    watch = spans.watch
    n_ticks = watch.n_ticks
    parts = dict.fromkeys(("step", "check", *map(str, _OF_A_CHANNEL), "runner"), 0)
    for span in _spans(watch.root):
        parts["runner" if span.part in _REMAINDERS else str(span.part)] += span.ns
    total_ns = sum(parts.values())
    parts["instruments"] = min(round(watch.n_readings * reading_us * 1e3), parts["runner"])
    parts["runner"] -= parts["instruments"]
    return Profile(
        graph=summary.graph,
        seed=summary.seed,
        outcome=summary.outcome,
        failure=summary.failure,
        clock=clock,
        ticks={kind.name.lower(): count for kind, count in sorted(spans.kinds.items(), key=lambda item: item[0].name)},
        parts={part: ns / n_ticks / 1e6 for part, ns in parts.items()},
        rate_hz=(summary.frames - 1) / summary.sim_s if summary.sim_s else 0.0,
        tick_ms=total_ns / n_ticks / 1e6,
        tick_p50_ms=watch.root.ticks.quantile_s(0.5) * 1e3,
        tick_p99_ms=watch.root.ticks.quantile_s(0.99) * 1e3,
        stages=tuple(_stages(graph, spans, total_ns)),
        channels=tuple(_channels(spans)),
        instruments=Instruments(
            readings=watch.n_readings / n_ticks,
            reading_us=reading_us,
            timed_p50_ms=watch.root.ticks.quantile_s(0.5) * 1e3,
            bare_p50_ms=spans.bare.quantile_s(0.5) * 1e3 if spans.bare.count else None,
        ),
        threads=_process_threads(),
        tree=_node(watch.root, graph, spans),
    )


def _spans(span: Span) -> Iterator[Span]:
    yield span
    for child in span.children.values():
        yield from _spans(child)


def _stages(graph: Graph, spans: TickSpans, total_ns: int) -> Iterator[StageTime]:
    """Yield the stages in the graph's order."""
    n_ticks = spans.watch.n_ticks
    for node in graph.nodes:
        fired = spans.watch.root.children.get((Part.STAGE, node.name))
        if fired is None or not fired.count:  # a tick that failed leaves spans without a count
            continue
        step = fired.children[Part.STEP, node.name]
        all_ns = sum(span.ns for span in _spans(fired))
        yield StageTime(
            name=node.name,
            use=node.use,
            steps=step.count,
            ms=step.ns / n_ticks / 1e6,
            p50_ms=step.ticks.quantile_s(0.5) * 1e3,
            p99_ms=step.ticks.quantile_s(0.99) * 1e3,
            share=step.ns / total_ns if total_ns else 0.0,
            beyond_ms=(all_ns - step.ns) / n_ticks / 1e6,
        )


def _channels(spans: TickSpans) -> Iterator[ChannelTime]:
    """Yield the channels in the order in which the graph writes them."""
    n_ticks = spans.watch.n_ticks
    ns: Counter[tuple[str, Part]] = Counter()
    decodes: Counter[str] = Counter()
    for span in _spans(spans.watch.root):
        if span.part in _OF_A_CHANNEL:
            ns[span.name, span.part] += span.ns
            decodes[span.name] += span.count if span.part is Part.DECODE else 0
    for name, count in spans.n_messages.items():
        encode, deliver, decode, log, tap = (ns[name, part] / n_ticks / 1e3 for part in _OF_A_CHANNEL)
        yield ChannelTime(
            name=name,
            messages=count / n_ticks,
            decodes=decodes[name] / n_ticks,
            n_bytes=spans.n_bytes[name] / count,
            encode_us=encode,
            deliver_us=deliver,
            decode_us=decode,
            log_us=log,
            tap_us=tap,
        )


def _node(span: Span, graph: Graph, spans: TickSpans) -> Node:
    """Return the box of a span, and below a step those of its functions."""
    n_ticks = spans.watch.n_ticks
    children = [_node(child, graph, spans) for child in span.children.values() if child.count]
    ms = span.ns / n_ticks / 1e6 + sum(child.ms for child in children)
    label, note = span.name, f"{span.count / n_ticks:.3g} in a tick"
    if span.part is Part.TICK:
        label, note = f"tick of {graph.path.stem}", ""
    elif span.part is Part.STAGE:
        note = graph.node(span.name).use
    elif span.part in {Part.STEP, Part.CHECK}:
        label, note = str(span.part), span.name
    else:
        label = f"{span.part} {span.name}"
    if span.part is Part.STEP and spans.functions is not None:
        children = [_function(function, ms) for function in spans.functions.of(span.name)]
    return Node(label, str(span.part), ms, note, tuple(children))


def _function(function: Function, step_ms: float) -> Node:
    calls = sorted(function.calls.values(), key=lambda one: -one.share)
    return Node(
        function.name,
        "function",
        function.share * step_ms,
        function.source,
        tuple(_function(one, step_ms) for one in calls),
    )


def _process_threads() -> dict[str, int]:
    """Return the number of threads that BLAS may use, and OpenCV where a plugin has loaded it."""
    found = {"blas": max((pool["num_threads"] for pool in threadpool_info() if pool["user_api"] == "blas"), default=1)}
    opencv = sys.modules.get("cv2")  # the core does not import it
    if opencv is not None:
        found["opencv"] = opencv.getNumThreads()
    return found
