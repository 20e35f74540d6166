"""Run a graph in lockstep into a run folder: the log, the resolved graph, the summary."""

from __future__ import annotations

import time
import uuid
from collections.abc import Callable, Collection, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import Protocol

from graphnav.bus import Bus
from graphnav.codec import encode, lcm_name, lcm_text_of
from graphnav.errors import GraphnavError, UserError
from graphnav.graph import Graph, resolved_yaml
from graphnav.interrupts import CtrlC, working_folder_restored
from graphnav.messages import About
from graphnav.record import ABOUT, LOG
from graphnav.record.threaded_writer import Log
from graphnav.runner.interrupt import Interrupt
from graphnav.runner.lockstep import Outcome, Runner
from graphnav.runner.lockstep_status import LockstepStatus
from graphnav.runner.owned_stages import Sink
from graphnav.runner.recording.failures import Failures
from graphnav.runner.recording.full_log import FullLog
from graphnav.runner.recording.kept_messages import kept, open_log, record_option
from graphnav.runner.recording.log_forecast import LogForecast
from graphnav.runner.recording.progress_file import ProgressFile
from graphnav.runner.recording.saved_graph import save_graph
from graphnav.runner.recording.stall import StallLimit, StallWatch, stall_error
from graphnav.runner.recording.summary import Summary, scores_of, steps_of, versions
from graphnav.runner.simulated_clock import SimulatedClock
from graphnav.runner.stage_calls import Call, StageCalls
from graphnav.stage import Stage

SUMMARY = "summary.json"


MakeRunner = Callable[[Graph, Mapping[str, Stage], Bus, Sequence[Sink]], Runner]


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
    make_runner: MakeRunner = Runner,
    stall: StallLimit | None = None,
    full: FullLog | None = None,
) -> Summary:
    """Run ``graph`` once into ``folder``, which must exist, and return the content of its ``summary.json``.

    A failing stage, a full disk and Ctrl-C end the run, but not its record: the log contains every complete message up
    to there, and the summary states how it ended. ``keep``: the channels to log, None for the graph's ``record``
    option. ``pace_ratio``: simulated seconds per wall second, None for as fast as the machine allows. ``on_tick`` gets
    the stamp of the next tick, ``on_failure`` every error in ``failure``, ``notice`` warnings of lateness and of a
    large log. ``make_runner``: a runner that measures, in place of the plain one; its sinks are the log and the tap.
    ``stall``: when a call into a stage that does not return ends the process, None for never. ``full``: gets all.

    Raises
    ------
    UserError
        The folder cannot be written.
    CtrlC
        The user asked for the end before the stages were wired, or after the run had reached its own.
    """
    graph, folder = _telling_what_is_kept(graph) if keep is None else graph, folder.absolute()
    run = _LockstepRun(graph, folder, Failures(on_failure), tap, run_id)
    with ProgressFile(folder, {node.name: node.use for node in graph.nodes}) as progress, Interrupt() as interrupt:
        clock = SimulatedClock(pace_ratio, sleep=interrupt.wait, notice=notice)
        try:
            with working_folder_restored(), ExitStack() as cleanup:
                run.watch(progress, stall, cleanup)
                run.begin(stages, keep, cleanup, make_runner, full)
                run.perform(clock, _forecast(graph, keep, run.writer, folder, notice), on_tick, interrupt.poll)
                interrupt.settle()
        except CtrlC:  # while it ended, such as in a stage that does not close
            if not run.is_begun:
                raise
            run.outcome = Outcome.STOPPED
        summary = run.summary(clock.behind_s)
        write_summary(summary, folder)
        raise_if_asked_late(interrupt, summary)
    return summary


class _LockstepRun:
    """A run in progress, from the first event of its log to its summary."""

    def __init__(self, graph: Graph, folder: Path, failures: Failures, tap: LiveSink | None, run_id: str) -> None:
        self._graph, self._folder, self._failures, self._tap, self._run_id = graph, folder, failures, tap, run_id
        self.outcome: str = Outcome.FAILED
        self._scores: dict[str, dict[str, float]] = {}
        self._wall_s = 0.0
        self._started_s = time.monotonic()
        self.is_begun = False
        """Whether the stages are wired, so that there is something to summarise."""

    def begin(
        self,
        stages: dict[str, Stage],
        keep: Collection[str] | None,
        cleanup: ExitStack,
        make_runner: MakeRunner,
        full: FullLog | None,
    ) -> None:
        """Open the log, announce the run and wire the stages; ``cleanup`` gets what closes all that."""
        self.writer = _begin(self._graph, self._folder)
        cleanup.callback(self._failures.close, self.writer.close)
        sinks = [kept(self._graph, self.writer, keep, is_live=False)]
        if self._tap is not None:
            cleanup.callback(self._tap.close)
            self._tap.announce(about_of(self._graph))
            sinks.append(self._tap)
        if full is not None and self._graph.run.record == "replayable":
            full.open(self._folder)
            full.write(ABOUT, 0, self._about())
            sinks.append(full)
        bus = Bus("memq://")
        cleanup.callback(bus.close)
        self._runner = make_runner(self._graph, stages, bus, sinks)
        for unit in self._runner.units.values():
            unit.calls = self._calls
        cleanup.callback(self._failures.close, self._runner.close)
        self.is_begun = True

    def watch(self, progress: ProgressFile, stall: StallLimit | None, cleanup: ExitStack) -> None:
        """Mark every call into a stage, and end the process if one does not return."""
        self._calls = StageCalls(progress.mark)
        if stall is None:
            return
        limit = stall

        def finish(call: Call) -> None:
            """Write what the thread of the run cannot write any more."""
            with self._failures.noted():
                raise stall_error(self._graph, call, limit.seconds)
            self._failures.close(self.writer.close)
            self._wall_s = time.monotonic() - self._started_s
            summary = self.summary(0.0)
            self._failures.close(lambda: write_summary(summary, self._folder))
            progress.remove()
            limit.on_stall(summary)

        cleanup.enter_context(StallWatch(self._calls, limit.seconds, finish))

    def perform(
        self,
        clock: SimulatedClock,
        forecast: LogForecast | None,
        on_tick: Callable[[int], None],
        should_stop: Callable[[], bool],
    ) -> None:
        """Run the stages to the end and read their scores."""
        runner, tap = self._runner, self._tap
        status = None if tap is None else LockstepStatus(runner, tap, self._run_id, lambda: tap.dropped)

        def before_tick(utime: int) -> bool:
            on_tick(utime)
            if forecast is not None:
                forecast.before_tick(utime)
            clock.advance(utime)
            if status is not None:
                status.before_tick(utime, clock.behind_s)
            return not should_stop()

        try:
            with self._failures.noted():
                self.writer.write(ABOUT, 0, self._about())
                runner.reset(self._graph.run.seed)
                self._started_s = time.monotonic()
                self.outcome = runner.run(self._graph.run.until_s, before_tick)
        except KeyboardInterrupt:
            self.outcome = Outcome.STOPPED
        with self._failures.noted():
            runner.give_stops()
        self._scores = scores_of(runner.units, self._failures.noted) if runner.is_ready else {}
        self._wall_s = time.monotonic() - self._started_s

    def _about(self) -> bytes:
        """Return the first event of the log."""
        return encode(about_of(self._graph), 0, 0)

    def summary(self, behind_s: float) -> Summary:
        """Return the summary of a run that has ended."""
        return Summary(
            outcome=str(Outcome.FAILED if self._failures else self.outcome),
            failure=str(self._failures),
            graph=self._graph.path.stem,
            seed=self._graph.run.seed,
            until_s=self._graph.run.until_s,
            frames=self._runner.ticks,
            sim_s=self._runner.utime / 1e6,
            wall_s=round(self._wall_s, 4),
            stages=steps_of(self._runner.units),
            scores=self._scores,
            notices=list(self._graph.notices),
            tap_dropped=self._tap.dropped if self._tap is not None else 0,
            run_id=self._run_id,
            versions=versions(),
            behind_s=round(behind_s, 4),
            cause=self._failures.cause,
        )


def _telling_what_is_kept(graph: Graph) -> Graph:
    """Return the graph for the log, which says what the log keeps, whatever the default is when it is read."""
    return replace(graph, run=replace(graph.run, record=record_option(graph.run.record, is_live=False)))


def write_summary(summary: Summary, folder: Path) -> None:
    """Write a summary into a run folder.

    Raises
    ------
    GraphnavError
        The file cannot be written.
    """
    try:
        summary.write(folder / SUMMARY)
    except GraphnavError as error:
        raise GraphnavError(f"{error}; the log up to here is complete") from error


def raise_if_asked_late(interrupt: Interrupt, summary: Summary) -> None:
    """Raise `CtrlC` if the user asked for the end of a run that had reached its own: nothing may follow it."""
    if interrupt.asked and summary.outcome not in (Outcome.STOPPED, Outcome.FAILED):
        raise CtrlC


def _begin(graph: Graph, folder: Path) -> Log:
    """Save the graph and open the log."""
    save_graph(graph, folder)
    try:
        return open_log(graph.run, folder / LOG)
    except OSError as error:
        raise UserError.of(f"cannot write into {folder}: {error.strerror}", "choose another folder with -o") from error


def _forecast(
    graph: Graph, keep: Collection[str] | None, writer: Log, folder: Path, notice: Callable[[str], None]
) -> LogForecast | None:
    """Return the forecast of the log's size, None for a log of selected channels or of small messages."""
    option = record_option(graph.run.record, is_live=False)
    if keep is not None or option == "small":
        return None
    return LogForecast(graph.run.until_s, writer, folder, notice, option=option)
