"""Run a graph live into a run folder: the log, the resolved graph, the summary."""

from __future__ import annotations

import threading
from collections.abc import Callable, Collection
from contextlib import ExitStack, closing
from functools import partial
from pathlib import Path

from graphnav.bus import same_group
from graphnav.codec import encode
from graphnav.errors import GraphnavError
from graphnav.graph import Graph
from graphnav.interrupts import CtrlC, working_folder_restored
from graphnav.live.about import live_about
from graphnav.live.clock import LiveClock
from graphnav.live.connections import opened
from graphnav.live.health.observer import Observer
from graphnav.live.health.status import Losses
from graphnav.live.health.watchdog import Watchdog
from graphnav.live.inputs.intake import Intake
from graphnav.live.inputs.playback import Playback
from graphnav.live.live_runner import LiveRunner
from graphnav.live.url import live_url
from graphnav.messages import Status
from graphnav.notices import print_notice
from graphnav.record import ABOUT, LOG, ThreadedLogWriter
from graphnav.runner.interrupt import Interrupt
from graphnav.runner.lockstep import Outcome
from graphnav.runner.lockstep_status import STATUS
from graphnav.runner.owned_stages import Sink
from graphnav.runner.recording.failures import Failures
from graphnav.runner.recording.kept_messages import ChannelsExcept, kept, open_log
from graphnav.runner.recording.progress_file import ProgressFile
from graphnav.runner.recording.run_recorded import LiveSink, raise_if_asked_late, write_summary
from graphnav.runner.recording.saved_graph import save_graph
from graphnav.runner.recording.stall import StallLimit, StallWatch, stall_error
from graphnav.runner.recording.summary import Summary, scores_of, steps_of, versions
from graphnav.runner.stage_calls import Call, StageCalls
from graphnav.stage import Stage


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
) -> Summary:
    """Run ``graph`` live into ``folder``, which must exist, and return the content of its ``summary.json``.

    Whatever ends the run, motor channels get a stop first. A failing stage and Ctrl-C end the run, a full disk only the
    recording. ``url``: see `live_url`. ``keep``: the channels to log, None for the graph's ``record`` option.
    ``on_time`` gets the seconds since the start now and then, ``notice`` gets warnings of late and lost messages;
    ``should_stop`` ends the run as Ctrl-C does, for runs outside the main thread. ``stall``: when a call into a stage
    that does not return ends the process, None for never; motor channels get a stop then, as whenever the run dies.

    Raises
    ------
    UserError
        The folder cannot be written, or a log to play does not contain the channels of the graph.
    CtrlC
        The user asked for the end before the stages were wired, or after the run had reached its own.
    """
    folder = folder.absolute()
    run = _LiveRun(graph, folder, live_url(graph, url), Failures(on_failure), tap)
    with ProgressFile(folder, {}) as progress, Interrupt() as interrupt:
        try:
            with working_folder_restored(), ExitStack() as cleanup:
                run.watch(stall, run_id, progress, cleanup)
                run.begin(stages, keep, run_id, notice, cleanup)
                run.perform(on_time, interrupt, lambda: interrupt.poll() or should_stop())
        except CtrlC:  # while it ended, such as in a stage that does not close
            if not run.is_begun:
                raise
            run.outcome = Outcome.STOPPED
        summary = run.summary(run_id)
        write_summary(summary, folder)
        raise_if_asked_late(interrupt, summary)
    return summary


class _LiveRun:
    """A run in progress, from the first event of its log to its summary."""

    def __init__(self, graph: Graph, folder: Path, url: str, failures: Failures, tap: LiveSink | None) -> None:
        self._graph, self._folder, self._url, self._failures, self._tap = graph, folder, url, failures, tap
        self._wake = threading.Event()
        self._calls = StageCalls()
        self.outcome: str = Outcome.FAILED
        self._scores: dict[str, dict[str, float]] = {}
        self.is_begun = False
        """Whether the stages are wired, so that there is something to summarise."""

    def watch(self, stall: StallLimit | None, run_id: str, progress: ProgressFile, cleanup: ExitStack) -> None:
        """End the process if a call into a stage does not return."""
        if stall is None:
            return
        limit = stall

        def finish(call: Call) -> None:
            """Write what the thread of the run cannot write any more."""
            with self._failures.noted():
                raise stall_error(self._graph, call, limit.seconds, self._clock.start_utime)
            self._observer.finish()
            self._writer.close()
            summary = self.summary(run_id)
            self._failures.close(lambda: write_summary(summary, self._folder))
            progress.remove()
            limit.on_stall(summary)

        cleanup.enter_context(StallWatch(self._calls, limit.seconds, finish))

    def begin(
        self,
        stages: dict[str, Stage],
        keep: Collection[str] | None,
        run_id: str,
        notice: Callable[[str], None],
        cleanup: ExitStack,
    ) -> None:
        """Open the logs that are written and played and wire the stages; ``cleanup`` gets what closes all that."""
        graph, tap = self._graph, self._tap
        save_graph(graph, self._folder)
        self._clock = LiveClock()
        intakes = [Intake(one, self._clock, needs_all=_needs_all(graph, ref)) for ref, one in graph.inputs.items()]
        played = [(one.source, one.mailbox) for one in intakes if one.source.log is not None]
        self._playback = Playback(played, self._wake.set)
        cleanup.callback(self._playback.close)
        self._writer = writer = ThreadedLogWriter(
            self._folder / LOG, notice=notice, open_log=partial(open_log, graph.run)
        )
        cleanup.callback(writer.close)
        self._runner = LiveRunner(graph, stages, self._clock, intakes, self._wake)
        for unit in self._runner.units.values():
            unit.calls = self._calls
        cleanup.callback(self._failures.close, self._runner.close)
        sinks = [kept(graph, writer, keep, is_live=True), *_watched(graph, tap, self._url)]
        self._runner.log_to(sinks, writer if keep is None else None)
        if tap is not None:
            cleanup.callback(tap.close)

        def losses() -> Losses:
            return Losses(tap.dropped if tap else 0, writer.dropped, writer.fault)

        self._observer = Observer(self._runner, run_id, self._url, losses, notice)
        self.is_begun = True

    def perform(self, on_time: Callable[[float], None], interrupt: Interrupt, should_stop: Callable[[], bool]) -> None:
        """Run the stages to the end and read their scores."""
        now = self._clock.now
        try:
            with self._failures.noted():
                about = live_about(self._graph, by_outside_names=False)
                self._writer.write(ABOUT, now(), encode(about, now(), 0))
                self._runner.reset(self._graph.run.seed)
                self._fire(on_time, interrupt, should_stop)
        except KeyboardInterrupt:
            self.outcome = Outcome.STOPPED
            self._observer.tell_broken_off()
        self._scores = scores_of(self._runner.units, self._failures.noted) if self._runner.is_ready else {}

    def _fire(self, on_time: Callable[[float], None], interrupt: Interrupt, should_stop: Callable[[], bool]) -> None:
        """Open what comes in and leaves, and fire the stages until the run ends."""
        graph, runner, observer, playback = self._graph, self._runner, self._observer, self._playback
        link = opened(graph, runner, self._url, self._wake, observer)
        with link as motors, closing(Watchdog(runner, observer.tell)):
            playback.start()

            def keep_going() -> bool:
                if observer.look():
                    on_time(self._clock.run_s())
                if motors is not None:
                    motors.check()
                if playback.failure:
                    raise GraphnavError(playback.failure)
                return not should_stop()

            try:
                self.outcome = runner.run(graph.run.until_s, keep_going, lambda: _is_over(graph, playback))
            finally:
                interrupt.settle()
                observer.finish()

    def summary(self, run_id: str) -> Summary:
        """Return the summary of a run that has ended."""
        status = self._observer.status
        return Summary(
            outcome=str(Outcome.FAILED if self._failures else self.outcome),
            failure=str(self._failures),
            graph=self._graph.path.stem,
            seed=self._graph.run.seed,
            until_s=self._graph.run.until_s,
            frames=self._runner.firings,
            sim_s=status.run_s,
            wall_s=round(status.wall_s, 4),
            stages=steps_of(self._runner.units),
            scores=self._scores,
            notices=[*self._graph.notices, *self._observer.told],
            tap_dropped=status.tap_dropped,
            run_id=run_id,
            versions=versions(),
            behind_s=status.behind_s,
            cause=self._failures.cause,
            live=_live_part(status, self._writer, self._url, self._observer.dropped_packets),
        )


def _watched(graph: Graph, tap: LiveSink | None, url: str) -> list[Sink]:
    """Return the sinks for viewers, without channels that other programs of the same group write or read."""
    if tap is None:
        return []
    is_shared = same_group(tap.url, url)
    outside = {STATUS, *(one.name for one in graph.inputs.values()), *(one.name for one in graph.outputs.values())}
    tap.announce(live_about(graph, by_outside_names=is_shared), outside)
    return [
        ChannelsExcept(tap, {graph.channels[ref].name for ref in (*graph.inputs, *graph.outputs)} if is_shared else ())
    ]


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
