"""Run a graph in lockstep as ``graphnav run`` does, and measure its ticks, and what the instruments cost."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable
from pathlib import Path

from graphnav import Graph, GraphnavError, Stage, UserError, shown_path
from graphnav.core.runner import LiveSink, Outcome, run_recorded
from graphnav.develop.parameters import Clock
from graphnav.develop.profiling.evaluate import profile_of
from graphnav.develop.profiling.profile import Profile
from graphnav.develop.profiling.step_functions import StepFunctions
from graphnav.develop.profiling.stopwatch import Part, Stopwatch
from graphnav.develop.profiling.tick_spans import WARM_UP, TickSpans, TimedSink

_CLOCKS: dict[Clock, Callable[[], int]] = {"wall": time.perf_counter_ns, "cpu": time.thread_time_ns}
_BATCHES, _MIN_WRITES = 9, 200


class NothingMeasuredError(GraphnavError):
    """The run ended before a tick was measured; ``outcome`` is that of the run."""

    def __init__(self, what: str, outcome: str) -> None:
        self.outcome = outcome
        super().__init__(what)


def measure(
    graph: Graph,
    stages: dict[str, Stage],
    folder: Path,
    *,
    functions: bool,
    clock: Clock = "wall",
    tap: LiveSink | None = None,
    run_id: str = "",
    on_tick: Callable[[int], None] = lambda _: None,
    on_failure: Callable[[GraphnavError], None] = lambda _: None,
    notice: Callable[[str], None] = lambda _: None,
) -> Profile:
    """Run ``graph`` once into ``folder``, which must exist, and return where the time of its ticks went.

    ``clock``: ``wall``, or ``cpu`` for the processor time of this thread, which is nearly the same on a busy machine.
    ``functions``: also sample the functions inside of the steps, which needs pyinstrument. A run that fails or is
    interrupted has the profile of its complete ticks. The other arguments are those of `run_recorded`.

    Raises
    ------
    UserError
        The folder cannot be written.
    NothingMeasuredError
        The run ended before a tick was measured.
    """
    spans = TickSpans(Stopwatch(_CLOCKS[clock]), StepFunctions() if functions else None)
    summary = run_recorded(
        graph,
        stages,
        folder,
        tap=tap,
        run_id=run_id,
        on_tick=on_tick,
        on_failure=on_failure,
        notice=notice,
        spans=spans,
    )
    if spans.watch.n_ticks:
        cost_us = _reading_us(max(1, len(spans.n_messages)), spans.watch.clock)
        return profile_of(graph, spans, summary, clock, cost_us)
    raise NothingMeasuredError(_why_nothing(summary.outcome, summary.failure, summary.frames), summary.outcome)


def refuse_live(graph: Graph) -> None:
    """Raise UserError for a graph with live inputs."""
    if graph.is_live:
        what = f"{shown_path(graph.path)}: a profile is taken in lockstep, but this graph has live inputs: "
        hint = "run it with 'graphnav run'; 'graphnav top' shows the times of its steps"
        raise UserError.of(what + ", ".join(graph.arriving), hint)


def _why_nothing(outcome: str, failure: str, n_ticks: int) -> str:
    what = f"nothing was measured: the run ended after {n_ticks} ticks, and the first {WARM_UP} only warm up"
    if outcome == Outcome.FAILED:
        return f"{failure}\n{what}"
    return what if outcome == Outcome.STOPPED else f"{what}\n  let it run longer, with --until or a longer input"


def _reading_us(n_channels: int, clock: Callable[[], int]) -> float:
    """Return the cost of one reading of the clock, microseconds, with the call around it that a plain run lacks.

    The median over batches of what a timed receiver of ``n_channels`` channels that does nothing takes longer than the
    receiver alone. In a tick it is rather more: caches hold other things.
    """
    names = [f"channel {number}" for number in range(n_channels)] * (1 + _MIN_WRITES // n_channels)
    watch, sink = Stopwatch(clock), _Nothing()
    timed = TimedSink(sink, Part.LOG, watch)
    found = []
    for _ in range(_BATCHES):
        begin_ns = clock()
        for name in names:
            sink.write(name, 0, b"")
        middle_ns = clock()
        watch.begin()
        for name in names:
            timed.write(name, 0, b"")
        end_ns = clock()
        found.append((end_ns - middle_ns - (middle_ns - begin_ns)) / (2 * len(names)) / 1e3)
    return max(0.0, statistics.median(found))


class _Nothing:
    """A receiver that does nothing."""

    def write(self, channel: str, utime: int, data: bytes) -> None:
        """Take one message."""
