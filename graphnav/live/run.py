"""Run a graph live into a run folder: the log, the resolved graph, the summary."""

from __future__ import annotations

import threading
from collections.abc import Callable, Collection, Mapping
from contextlib import ExitStack, closing, suppress
from pathlib import Path

from graphnav import About, Graph, GraphnavError, Stage, Status
from graphnav.core.bus import Bus
from graphnav.core.codec import encode
from graphnav.core.dds import Ros2Node
from graphnav.core.graph import InputChannel, OutputChannel
from graphnav.core.interrupts import Interrupt
from graphnav.core.lcm_url import live_url
from graphnav.core.notices import print_notice
from graphnav.core.record import ThreadedLogWriter
from graphnav.core.run_folder import RunFolder
from graphnav.core.runner import (
    Changes,
    LiveSink,
    Measured,
    Outcome,
    RecordedRun,
    RemoteProcesses,
    RemoteStage,
    RemoteUnit,
    Sink,
    StageCalls,
    StallLimit,
    Summary,
    about_of,
)
from graphnav.live.clock import LiveClock
from graphnav.live.connections import joined_ros2, opened
from graphnav.live.health.observer import Observer
from graphnav.live.health.service_manager import ServiceManager
from graphnav.live.health.status import Losses
from graphnav.live.inputs.intake import Intake
from graphnav.live.inputs.playback import Playback
from graphnav.live.live_schedule import LiveSchedule
from graphnav.live.process_schedule import ProcessSchedule, WakeEvent

Apart = tuple[RemoteProcesses, Mapping[str, RemoteStage]]
"""Processes, and the stages that live there, by name."""
StartProcesses = Callable[[Interrupt], Apart]

_WATCH_PERIOD_S = 0.5
_HANGS_S = 1.0
"""A step that takes longer is told of."""


def run_live(
    graph: Graph,
    stages: dict[str, Stage],
    folder: Path,
    *,
    url: str | None = None,
    keep: Collection[str] | None = None,
    tap: LiveSink | None = None,
    run_id: str = "",
    on_time: Callable[[float], None] = lambda _: None,
    on_failure: Callable[[GraphnavError], None] = lambda _: None,
    notice: Callable[[str], None] = print_notice,
    should_stop: Callable[[], bool] = lambda: False,
    stall: StallLimit | None = None,
    changes: Changes | None = None,
    start_processes: StartProcesses | None = None,
) -> Summary:
    """Run ``graph`` live into ``folder``, which must exist, and return the content of its ``summary.json``.

    Whatever ends the run, motor channels get a stop first. A failing stage and Ctrl-C end the run, a full disk only the
    recording. ``url``: see `live_url`. ``keep``: the channels to log, None for the graph's ``record`` option.
    ``on_time`` gets the seconds since the start now and then, ``notice`` gets warnings of late and lost messages;
    ``should_stop`` ends the run as Ctrl-C does, for runs outside the main thread. ``stall``: when a call into a stage
    that does not return ends the process, None for never; motor channels get a stop then, as whenever the run dies.
    ``changes`` may change its stages while it lasts. ``start_processes``: starts the processes of stages that live in
    others, None where all live in this one.

    Raises
    ------
    UserError
        The folder cannot be written, a log to play does not contain the channels of the graph, or Cyclone DDS is not
        installed for its ROS 2 topics.
    BusError
        The domain of its ROS 2 topics cannot be joined.
    CtrlC
        The user asked for the end before the stages were wired, or after the run had reached its own.
    """
    manager = ServiceManager(notice)

    def run_with(interrupt: Interrupt, calls: StageCalls, cleanup: ExitStack) -> None:
        run.begin(stages, keep, notice, calls, cleanup, None if start_processes is None else start_processes(interrupt))
        run.perform(on_time, interrupt, lambda: interrupt.asked or should_stop())

    with joined_ros2(graph) as node:
        run = _LiveRun(graph, folder.absolute(), live_url(graph, url), node, tap, run_id, on_failure, changes, manager)
        return run.record.conduct(run_with, stall, {})


class _LiveRun:
    """A run in progress, from the first event of its log to its summary."""

    def __init__(
        self,
        graph: Graph,
        folder: Path,
        url: str,
        node: Ros2Node | None,
        tap: LiveSink | None,
        run_id: str,
        on_failure: Callable[[GraphnavError], None],
        changes: Changes | None,
        manager: ServiceManager,
    ) -> None:
        self._graph, self._folder, self._url, self._tap, self._run_id = graph, folder, url, tap, run_id
        self._node = node
        self._changes, self._manager = changes, manager
        self.record = RecordedRun(graph, folder, run_id, on_failure, self._close_log, self._measured, changes)
        self._processes: RemoteProcesses | None = None

    def begin(
        self,
        stages: dict[str, Stage],
        keep: Collection[str] | None,
        notice: Callable[[str], None],
        calls: StageCalls,
        cleanup: ExitStack,
        apart: Apart | None,
    ) -> None:
        """Open the logs that are written and played and wire the stages; ``cleanup`` gets what closes all that."""
        graph, tap = self._graph, self._tap
        self.record.save_graph()
        self._wake = cleanup.enter_context(closing(WakeEvent()))
        self._clock = LiveClock()
        intakes = [Intake(one, self._clock, needs_all=_needs_all(graph, ref)) for ref, one in graph.inputs.items()]
        played = [(one.source, one.mailbox) for one in intakes if one.source.log is not None]
        self._playback = Playback(played, self._wake.set)
        cleanup.callback(self._playback.close)
        self._writer = writer = ThreadedLogWriter(
            self._folder / RunFolder.LOG, notice=notice, open_log=self.record.open_log
        )
        cleanup.callback(writer.close)
        if tap is not None:
            cleanup.callback(tap.close)
        sinks = [self.record.kept(writer, keep, is_live=True), *_watched(graph, tap, self._url)]
        firings = writer if keep is None else None
        if apart is None:
            self._schedule = LiveSchedule(graph, stages, self._clock, intakes, self._wake, sinks, firings, calls)
        else:
            self._processes = apart[0]
            self._schedule = ProcessSchedule(
                graph, stages, self._clock, intakes, self._wake, sinks, firings, calls, *apart
            )
        cleanup.callback(self.record.failures.close, self._schedule.close)

        def losses() -> Losses:
            return Losses(tap.dropped if tap else 0, writer.dropped, writer.fault)

        self._observer = Observer(self._schedule, self._run_id, self._url, losses, notice)
        self.record.engine = self._schedule.engine

    def perform(self, on_time: Callable[[float], None], interrupt: Interrupt, should_stop: Callable[[], bool]) -> None:
        """Run the stages to the end and read their scores."""
        now = self._clock.now
        try:
            with self.record.failures.noted():
                about = about_of(self._graph, is_live=True)
                self._writer.write(About.CHANNEL, now(), encode(about, now(), 0))
                self._schedule.reset(self._graph.run.seed)
                self._fire(on_time, interrupt, should_stop)
        except KeyboardInterrupt:
            self.record.outcome = Outcome.STOPPED
            self._observer.tell_broken_off()
        with self.record.failures.noted(), suppress(KeyboardInterrupt):
            self._schedule.settle()
        self.record.read_scores()

    def _fire(self, on_time: Callable[[float], None], interrupt: Interrupt, should_stop: Callable[[], bool]) -> None:
        """Open what comes in and leaves, and fire the stages until the run ends."""
        graph, schedule, observer, playback = self._graph, self._schedule, self._observer, self._playback
        manager = self._manager
        link = opened(graph, schedule, self._url, self._node, self._wake, observer)
        with link as motors, closing(Watchdog(schedule, observer.tell)):
            playback.start()
            sinks: list[Sink] = [self._writer] if self._tap is None else [self._writer, self._tap]
            if self._changes is not None:
                self._changes.begin(schedule)
            manager.tell_ready()

            def keep_going() -> bool:
                manager.tell_turn()
                if observer.look():
                    manager.tell_status(observer.in_one_line())
                    on_time(self._clock.run_s())
                if motors is not None:
                    motors.check()
                if playback.failure:
                    raise GraphnavError(playback.failure)
                if should_stop():
                    return False
                if self._changes is not None:
                    self._changes.take(self._clock.now(), sinks, is_busy=not schedule.is_idle)
                return True

            try:
                self.record.outcome = schedule.run(graph.run.until_s, keep_going, lambda: _is_over(graph, playback))
            finally:
                manager.tell_end()
                interrupt.settle()
                observer.finish()
                observer.tell_processes()

    def _close_log(self) -> None:
        self._observer.finish()
        self._writer.close()

    def _measured(self) -> Measured:
        status = self._observer.status
        return Measured(
            sim_s=status.run_s,
            wall_s=status.wall_s,
            behind_s=status.behind_s,
            tap_dropped=status.tap_dropped,
            notices=tuple(self._observer.told),
            processes=None if self._processes is None else self._processes.report(),
            live=_live_part(status, self._writer, self._url, self._observer.dropped_packets),
        )


def _watched(graph: Graph, tap: LiveSink | None, url: str) -> list[Sink]:
    """Return the sinks for viewers, without channels that other programs of the same group write or read."""
    if tap is None:
        return []
    is_shared = Bus.same_group(tap.url, url)
    outside = {
        Status.CHANNEL,
        *(one.name for one in graph.inputs.values() if one.ros_type is None),
        *(one.name for one in graph.outputs.values() if one.ros_type is None),
    }
    tap.announce(about_of(graph, is_live=True, by_outside_names=is_shared), outside)
    if not is_shared:
        return [tap]
    wires: dict[str, InputChannel | OutputChannel] = {**graph.inputs, **graph.outputs}
    shared = frozenset(graph.channels[ref].name for ref, one in wires.items() if one.ros_type is None)
    return [_Unshared(tap, shared)]


class _Unshared:
    """Passes on the messages of all channels except those that other programs write or read."""

    def __init__(self, sink: Sink, channels: frozenset[str]) -> None:
        self._sink, self._channels = sink, channels

    def write(self, channel: str, utime: int, data: bytes) -> None:
        """Write one message."""
        if channel not in self._channels:
            self._sink.write(channel, utime, data)


def _is_over(graph: Graph, playback: Playback) -> bool:
    """Whether no more input can arrive: every log has been played, and there is no other source."""
    return bool(graph.inputs) and not graph.sources and playback.is_over and all(i.log for i in graph.inputs.values())


def _needs_all(graph: Graph, ref: str) -> bool:
    """Whether every message of an input counts, not only the newest."""
    for node in graph.nodes:
        plain = [i for i in node.inputs if i.port.is_plain]
        for i in node.inputs:
            if i.channel is None or i.channel.ref != ref:
                continue
            queued = any(f"{node.name}.{one.port.name}" in graph.queues for one in plain)
            if i.port.since or (i.port.is_plain and (len(plain) > 1 or queued)):
                return True
    return False


def _live_part(status: Status, writer: ThreadedLogWriter, url: str, dropped_packets: int) -> dict[str, object]:
    """Return the part of the summary that only live runs have."""
    return {
        "url": url,
        "inputs": list(status.inputs),
        "outputs": list(status.outputs),
        "edges": list(status.edges),
        "missed": {stage["name"]: stage["missed"] for stage in status.stages if stage["deadline_ms"]},
        "dropped_packets": dropped_packets,
        "memory_mb": status.memory_mb,
        "log_dropped": writer.dropped,
        "log_failure": writer.failure,
        "log_gaps": [gap._asdict() for gap in writer.gaps],
    }


class Watchdog:
    """Reports through ``notice``, once per step, a stage that has been in one step for more than a second.

    It looks from a separate thread. A native call of a stage of this process that holds Python's interpreter lock
    blocks it too: then only the motor process acts.
    """

    def __init__(self, schedule: LiveSchedule, notice: Callable[[str], None]) -> None:
        self._schedule, self._notice = schedule, notice
        self._apart = {name for name, unit in schedule.engine.units.items() if isinstance(unit, RemoteUnit)}
        self._ending = threading.Event()
        self._thread = threading.Thread(target=self._serve, name="graphnav-watchdog", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Stop watching."""
        self._ending.set()
        self._thread.join()

    def _serve(self) -> None:
        told: set[tuple[str, float]] = set()
        while not self._ending.wait(_WATCH_PERIOD_S):
            steps, now_s = set(self._schedule.steps.items()), self._schedule.clock.now_s()
            told &= steps
            for name, began_s in steps - told:
                if now_s - began_s > _HANGS_S:
                    told.add((name, began_s))
                    effect = "what reads it gets nothing" if name in self._apart else "motor channels get stops"
                    self._notice(f"hangs: {name} has been in one step for {now_s - began_s:.1f} s; {effect}")
