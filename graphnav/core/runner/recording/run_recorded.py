"""Run a graph in lockstep into a run folder: the log, the resolved graph, the summary; what describes a run."""

from __future__ import annotations

import time
import uuid
from collections.abc import Callable, Collection, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import Protocol

import graphnav_lcm

from graphnav.core.codec import encode, lcm_name, lcm_text_of
from graphnav.core.errors import GraphnavError, UserError
from graphnav.core.graph import Graph, resolved_yaml
from graphnav.core.interrupts import Interrupt
from graphnav.core.messages import About, Fired, Gap, Status
from graphnav.core.record.threaded_writer import Log
from graphnav.core.run_folder import RunFolder
from graphnav.core.runner.engine import Outcome, Sink, Spans
from graphnav.core.runner.lockstep import Lockstep
from graphnav.core.runner.recording.changes import Changes
from graphnav.core.runner.recording.full_log import FullLog
from graphnav.core.runner.recording.kept_messages import record_option
from graphnav.core.runner.recording.log_forecast import LogForecast
from graphnav.core.runner.recording.recorded_run import Measured, RecordedRun
from graphnav.core.runner.recording.stall import StallLimit
from graphnav.core.runner.recording.summary import Summary
from graphnav.core.runner.simulated_clock import SimulatedClock
from graphnav.core.runner.stage_calls import StageCalls
from graphnav.core.runner.status import LockstepStatus
from graphnav.core.stage import Stage


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


def about_of(graph: Graph, *, is_live: bool = False, by_outside_names: bool = False) -> About:
    """Return the `About` message of a run for its log or its tap; the tap adds the run's id.

    ``by_outside_names``: list the inputs and outputs of a live run under their LCM channels and types, for viewers on
    the group on which other programs write and read them.
    """
    channels = sorted(graph.channels.values(), key=lambda channel: channel.name)
    types = [channel.message.lcm_class for channel in channels]
    about = About(
        graph_yaml=resolved_yaml(replace(graph, deploy={})),  # which changes no message
        lcm_text=lcm_text_of(types),
        run_id="",
        seed=graph.run.seed,
        channels=tuple(channel.name for channel in channels),
        types=tuple(map(lcm_name, types)),
    )
    return _live(about, graph, by_outside_names=by_outside_names) if is_live else about


def _live(about: About, graph: Graph, *, by_outside_names: bool) -> About:
    """Return the description of a live run."""
    channels = dict(zip(about.channels, about.types, strict=True))
    classes = [channel.message.lcm_class for channel in graph.channels.values()]
    if by_outside_names:
        for ref, target in graph.outputs.items():
            if target.ros_type is not None:
                continue
            channels.pop(graph.channels[ref].name)
            channels[target.name] = target.type_name
            classes.append(target.lcm_class)
        for ref, source in graph.inputs.items():
            if source.ros_type is not None:
                continue
            channels.pop(graph.channels[ref].name)
            if source.log is None:
                channels[source.name] = source.type_name
                classes.append(source.lcm_class)
    channels[Status.CHANNEL] = lcm_name(graphnav_lcm.status_t)
    classes.append(graphnav_lcm.status_t)
    if not by_outside_names:
        channels |= {Fired.CHANNEL: lcm_name(graphnav_lcm.fired_t), Gap.CHANNEL: lcm_name(graphnav_lcm.gap_t)}
        classes += [graphnav_lcm.fired_t, graphnav_lcm.gap_t]
    ordered = sorted(channels.items())
    return replace(
        about,
        lcm_text=lcm_text_of(classes),
        channels=tuple(name for name, _ in ordered),
        types=tuple(kind for _, kind in ordered),
    )


class MakeLockstep(Protocol):
    """Makes the schedule of a run; the interrupt says when the user asks for the end."""

    def __call__(
        self,
        graph: Graph,
        stages: Mapping[str, Stage],
        sinks: Sequence[Sink],
        spans: Spans | None,
        calls: StageCalls,
        interrupt: Interrupt,
    ) -> Lockstep:
        """Wire ``stages`` (by name) of ``graph``; see `Lockstep`."""


def _in_this_process(
    graph: Graph,
    stages: Mapping[str, Stage],
    sinks: Sequence[Sink],
    spans: Spans | None,
    calls: StageCalls,
    interrupt: Interrupt,  # noqa: ARG001 - a step that does not return is interrupted by an exception
) -> Lockstep:
    return Lockstep(graph, stages, sinks, spans, calls)


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
    spans: Spans | None = None,
    stall: StallLimit | None = None,
    full: FullLog | None = None,
    changes: Changes | None = None,
    make_lockstep: MakeLockstep = _in_this_process,
) -> Summary:
    """Run ``graph`` once into ``folder``, which must exist, and return the content of its ``summary.json``.

    A failing stage, a full disk and Ctrl-C end the run, but not its record: the log contains every complete message up
    to there, and the summary states how it ended. ``keep``: the channels to log, None for the graph's ``record``
    option. ``pace_ratio``: simulated seconds per wall second, None for as fast as the machine allows. ``on_tick`` gets
    the stamp of the next tick, ``on_failure`` every error in ``failure``, ``notice`` warnings of lateness and of a
    large log. ``spans``: measures the work. ``stall``: when a call into a stage that does not return ends the process,
    None for never. ``full``: gets all. ``changes`` its stages while it lasts. ``make_lockstep`` makes the schedule.

    Raises
    ------
    UserError
        The folder cannot be written.
    CtrlC
        The user asked for the end before the stages were wired, or after the run had reached its own.
    """
    graph = _telling_what_is_kept(graph) if keep is None else graph
    run = _LockstepRun(graph, folder.absolute(), tap, run_id, on_failure, changes)

    def run_with(interrupt: Interrupt, calls: StageCalls, cleanup: ExitStack) -> None:
        run.clock = SimulatedClock(pace_ratio, sleep=interrupt.wait, notice=notice)
        run.begin(lambda sinks: make_lockstep(graph, stages, sinks, spans, calls, interrupt), keep, cleanup, full)
        forecast = _forecast(graph, keep, run.writer, run.folder, notice)
        run.perform(forecast, on_tick, lambda: interrupt.asked)

    return run.record.conduct(run_with, stall, {node.name: node.use for node in graph.nodes})


class _LockstepRun:
    """A run in progress, from the first event of its log to its summary."""

    def __init__(
        self,
        graph: Graph,
        folder: Path,
        tap: LiveSink | None,
        run_id: str,
        on_failure: Callable[[GraphnavError], None],
        changes: Changes | None,
    ) -> None:
        self._graph, self.folder, self._tap, self._run_id = graph, folder, tap, run_id
        self._changes = changes
        self.record = RecordedRun(graph, folder, run_id, on_failure, self._close_log, self._measured, changes)
        self.clock = SimulatedClock()
        self._wall_s: float | None = None
        self._started_s = time.monotonic()

    def begin(
        self,
        wire: Callable[[Sequence[Sink]], Lockstep],
        keep: Collection[str] | None,
        cleanup: ExitStack,
        full: FullLog | None,
    ) -> None:
        """Open the log, announce the run and wire the stages; ``cleanup`` gets what closes all that."""
        close = self.record.failures.close
        self.record.save_graph()
        self.writer = self._opened_log()
        cleanup.callback(close, self.writer.close)
        sinks: list[Sink] = [self.record.kept(self.writer, keep, is_live=False)]
        if self._tap is not None:
            cleanup.callback(self._tap.close)
            self._tap.announce(about_of(self._graph))
            sinks.append(self._tap)
        if full is not None and self._graph.run.record == "replayable":
            full.open(self.folder)
            full.write(About.CHANNEL, 0, self._about())
            sinks.append(full)
        self._takes_all = [self.writer, *sinks[1:]]
        """Receive what no ``record`` option leaves out."""
        self._lockstep = wire(sinks)
        self.record.engine = self._lockstep.engine
        cleanup.callback(close, self._lockstep.engine.close)

    def perform(
        self, forecast: LogForecast | None, on_tick: Callable[[int], None], should_stop: Callable[[], bool]
    ) -> None:
        """Run the stages to the end and read their scores."""
        record, lockstep, clock, tap = self.record, self._lockstep, self.clock, self._tap
        engine, status = lockstep.engine, None
        if tap is not None:
            dropped, states = (lambda: tap.dropped), (lambda: lockstep.process_states)
            status = told = LockstepStatus(self._graph, engine, tap, self._run_id, dropped, states)
            lockstep.while_waiting = lambda: told.look(engine.utime, clock.behind_s)

        def before_tick(utime: int) -> bool:
            on_tick(utime)
            if forecast is not None:
                forecast.before_tick(utime)
            clock.advance(utime)
            if status is not None:
                status.look(utime, clock.behind_s)
            if should_stop():
                return False
            if self._changes is not None:
                self._changes.take(utime, self._takes_all)
            return True

        try:
            with record.failures.noted():
                self.writer.write(About.CHANNEL, 0, self._about())
                lockstep.reset(self._graph.run.seed)
                self._started_s = time.monotonic()
                if self._changes is not None:
                    self._changes.begin(lockstep)
                record.outcome = lockstep.run(self._graph.run.until_s, before_tick)
        except KeyboardInterrupt:
            record.outcome = Outcome.STOPPED
        if status is not None:
            status.publish(engine.utime, clock.behind_s)  # says which process is gone, and what the tap left out
        with record.failures.noted():
            engine.give_stops(engine.sinks)
        record.read_scores()
        self._wall_s = time.monotonic() - self._started_s

    def _about(self) -> bytes:
        """Return the first event of the log."""
        return encode(about_of(self._graph), 0, 0)

    def _opened_log(self) -> Log:
        try:
            return self.record.open_log(self.folder / RunFolder.LOG)
        except OSError as error:
            what = f"cannot write into {self.folder}: {error.strerror}"
            raise UserError.of(what, "choose another folder with -o") from error

    def _close_log(self) -> None:
        self.writer.close()

    def _measured(self) -> Measured:
        return Measured(
            sim_s=self._lockstep.engine.utime / 1e6,
            wall_s=time.monotonic() - self._started_s if self._wall_s is None else self._wall_s,
            behind_s=round(self.clock.behind_s, 4),
            tap_dropped=self._tap.dropped if self._tap is not None else 0,
            processes=self._lockstep.processes,
        )


def _telling_what_is_kept(graph: Graph) -> Graph:
    """Return the graph for the log, which says what the log keeps, whatever the default is when it is read."""
    return replace(graph, run=replace(graph.run, record=record_option(graph.run.record, is_live=False)))


def _forecast(
    graph: Graph, keep: Collection[str] | None, writer: Log, folder: Path, notice: Callable[[str], None]
) -> LogForecast | None:
    """Return the forecast of the log's size, None for a log of selected channels or of small messages."""
    option = record_option(graph.run.record, is_live=False)
    if keep is not None or option == "small":
        return None
    return LogForecast(graph.run.until_s, writer, folder, notice, option=option)
