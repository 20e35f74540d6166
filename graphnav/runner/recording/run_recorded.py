"""Run a graph in lockstep into a run folder: the log, the resolved graph, the summary."""

from __future__ import annotations

import time
import uuid
from collections.abc import Callable, Collection
from contextlib import ExitStack
from pathlib import Path
from typing import Protocol

from graphnav.bus import Bus
from graphnav.clock import SimulatedClock
from graphnav.codec import encode, lcm_name, lcm_text_of
from graphnav.errors import GraphnavError, UserError
from graphnav.graph import Graph, resolved_yaml
from graphnav.messages import About
from graphnav.record import ABOUT, LOG, LogWriter
from graphnav.runner.interrupt import Interrupt
from graphnav.runner.lockstep import Outcome, Runner
from graphnav.runner.lockstep_status import LockstepStatus
from graphnav.runner.owned_stages import Sink
from graphnav.runner.recording.kept_messages import ChannelsOnly, SmallOnly
from graphnav.runner.recording.log_forecast import LogForecast
from graphnav.runner.recording.saved_graph import save_graph
from graphnav.runner.recording.summary import Summary, figures_of, scores_of, versions
from graphnav.stage import Stage

SUMMARY = "summary.json"


class LiveSink(Sink, Protocol):
    """A sink that viewers follow during the run: the tap."""

    dropped: int
    url: str

    def announce(self, about: About, shareable: Collection[str] = ()) -> None:
        """Publish ``graphnav.about`` repeatedly."""

    def close(self) -> None:
        """Send pending messages and stop."""


def new_run_id() -> str:
    """Return a unique name for a run."""
    return uuid.uuid4().hex[:8]


def about_of(graph: Graph) -> About:
    """Return the `About` message of a graph for the log or the tap; the tap adds the run's id."""
    channels = sorted(graph.channels.values(), key=lambda channel: channel.name)
    types = [channel.message.lcm_class for channel in channels]
    return About(
        graph_yaml=resolved_yaml(graph),
        lcm_text=lcm_text_of(types),
        run_id="",
        seed=graph.run.seed,
        channels=tuple(channel.name for channel in channels),
        types=tuple(map(lcm_name, types)),
    )


def run_recorded(
    graph: Graph,
    stages: dict[str, Stage],
    folder: Path,
    *,
    keep: Collection[str] | None = None,
    pace_ratio: float | None = None,
    tap: LiveSink | None = None,
    run_id: str = "",
    on_tick: Callable[[int], None] = lambda _: None,
    on_failure: Callable[[GraphnavError], None] = lambda _: None,
    notice: Callable[[str], None] = lambda _: None,
) -> Summary:
    """Run ``graph`` once into ``folder``, which must exist, and return the content of its ``summary.json``.

    A failing stage, a full disk and Ctrl-C end the run, but not its record: the log contains every complete message up
    to there, and the summary states how it ended. ``keep``: the channels to log, None for the graph's ``record``
    option. ``pace_ratio``: simulated seconds per wall second, None for as fast as the machine allows. ``on_tick`` gets
    the stamp of the next tick, ``on_failure`` every error in ``failure``, ``notice`` warnings of lateness and of a
    large log.

    Raises
    ------
    UserError
        The folder cannot be written.
    """
    failures: list[str] = []
    outcome: str = Outcome.FAILED
    scores: dict[str, dict[str, float]] = {}
    with ExitStack() as cleanup, Interrupt() as interrupt:
        writer = _begin(graph, folder)
        started = time.monotonic()
        cleanup.callback(note_failure, failures, on_failure, writer.close)
        sinks = [_kept(graph, writer, keep)]
        if tap is not None:
            cleanup.callback(tap.close)
            tap.announce(about_of(graph))
            sinks.append(tap)
        bus = Bus("memq://")
        cleanup.callback(bus.close)
        runner = Runner(graph, stages, bus, sinks)
        cleanup.callback(note_failure, failures, on_failure, runner.close)
        clock = SimulatedClock(pace_ratio, sleep=interrupt.wait, notice=notice)
        status = None if tap is None else LockstepStatus(runner, tap, run_id, lambda: tap.dropped)
        forecast = LogForecast(graph.run.until_s, writer, folder, notice) if _keeps_all(graph, keep) else None

        def before_tick(utime: int) -> bool:
            on_tick(utime)
            if forecast is not None:
                forecast.before_tick(utime)
            clock.advance(utime)
            if status is not None:
                status.before_tick(utime, clock.behind_s)
            return not interrupt.asked

        try:
            writer.write(ABOUT, 0, encode(about_of(graph), 0, 0))
            runner.reset(graph.run.seed)
            started = time.monotonic()
            outcome = runner.run(graph.run.until_s, before_tick)
        except KeyboardInterrupt:
            outcome = Outcome.STOPPED
        except GraphnavError as error:
            failures.append(str(error))
            on_failure(error)
        try:
            scores = scores_of(runner.units) if runner.is_ready else {}
        except GraphnavError as error:
            failures.append(str(error))
            on_failure(error)
        wall_s = time.monotonic() - started
    summary = Summary(
        outcome=str(Outcome.FAILED if failures else outcome),
        failure="\n".join(failures),
        graph=graph.path.stem,
        seed=graph.run.seed,
        until_s=graph.run.until_s,
        frames=runner.ticks,
        sim_s=runner.utime / 1e6,
        wall_s=round(wall_s, 4),
        stages=figures_of(runner.units),
        scores=scores,
        notices=list(graph.notices),
        tap_dropped=tap.dropped if tap is not None else 0,
        run_id=run_id,
        versions=versions(),
        behind_s=round(clock.behind_s, 4),
    )
    write_summary(summary, folder)
    return summary


def write_summary(summary: Summary, folder: Path) -> None:
    """Write a summary into a run folder.

    Raises
    ------
    GraphnavError
        The file cannot be written.
    """
    try:
        summary.write(folder / SUMMARY)
    except OSError as error:
        raise GraphnavError(
            f"cannot write {folder / SUMMARY}: {error.strerror}; the log up to here is complete"
        ) from error


def _begin(graph: Graph, folder: Path) -> LogWriter:
    """Save the graph and open the log."""
    save_graph(graph, folder)
    try:
        return LogWriter(folder / LOG)
    except OSError as error:
        raise UserError.of(f"cannot write into {folder}: {error.strerror}", "choose another folder with -o") from error


def _kept(graph: Graph, writer: LogWriter, keep: Collection[str] | None) -> Sink:
    """Return the sink of the log."""
    if keep is not None:
        return ChannelsOnly(writer, keep)
    return writer if _keeps_all(graph, keep) else SmallOnly(writer)


def _keeps_all(graph: Graph, keep: Collection[str] | None) -> bool:
    """Whether the log contains every message."""
    return keep is None and graph.run.record != "small"


def note_failure(failures: list[str], on_failure: Callable[[GraphnavError], None], close: Callable[[], None]) -> None:
    """Close something; errors are appended to ``failures`` for the summary."""
    try:
        close()
    except GraphnavError as error:
        if str(error) not in failures:
            failures.append(str(error))
            on_failure(error)
