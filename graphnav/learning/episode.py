"""One episode: the stages of a graph in a world, stepped between the actions of an agent, recorded if asked."""

from __future__ import annotations

import time
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from graphnav import About, DeclarationError, Graph, GraphnavError, Message, Stage, UserError
from graphnav.core.codec import decode, encode
from graphnav.core.errors import StageError, one_line
from graphnav.core.graph import Channel
from graphnav.core.run_folder import RunFolder
from graphnav.core.runner import Measured, Outcome, RecordedRun, Sink, about_of, new_run_id
from graphnav.core.stage import measured_metrics, metrics_of
from graphnav.learning.agent import Agent
from graphnav.learning.split_lockstep import SplitLockstep


class Newest:
    """A sink that keeps the newest message of some channels."""

    def __init__(self, channels: Collection[Channel]) -> None:
        self._channels = {channel.name: channel for channel in channels}
        self._data: dict[str, bytes] = {}

    def write(self, channel: str, _utime: int, data: bytes) -> None:
        """Keep a message if it is of one of the channels."""
        if channel in self._channels:
            self._data[channel] = data

    def __call__(self, ref: str) -> Any:
        """Return the newest message of a channel by its reference, None before the first."""
        found = next((channel for channel in self._channels.values() if channel.ref == ref), None)
        if found is None or (data := self._data.get(found.name)) is None:
            return None
        return decode(found.message, data)[2]


class Episode:
    """A world from its start to its end, and the agent in it.

    ``agent``: its stage. ``watched``: channels whose newest message `newest` returns. ``folder``: where it is recorded,
    which exists.

    Raises GraphnavError if a stage cannot be made or reset, or the folder not written.
    """

    def __init__(self, graph: Graph, agent: str, watched: Collection[Channel], folder: Path | None) -> None:
        self._graph, self._until_us = graph, _microseconds(graph.run.until_s)
        self._stages = graph.make_stages()
        stage = self._stages[agent]
        assert isinstance(stage, Agent)
        self._agent = stage
        self.newest = Newest(watched)
        self._record = None if folder is None else _Record(graph, folder)
        sinks: list[Sink] = [*([] if self._record is None else self._record.sinks), *([self.newest] if watched else [])]
        self.schedule = SplitLockstep(graph, self._stages, sinks, agent)
        self._inputs: Mapping[str, Any] | None = None
        self.is_closed = False
        """Whether its stages are closed and its record is complete."""
        self.outcome = ""
        """How it ended, "" while it goes on."""
        try:
            if self._record is not None:
                self._record.begin(self.schedule)
            self.schedule.reset(graph.run.seed)
        except GraphnavError:
            self.close(Outcome.FAILED)
            raise

    @property
    def utime(self) -> int:
        """The stamp of the newest tick, microseconds."""
        return self.schedule.engine.utime

    def advance(self, answer: Message | None) -> Mapping[str, Any] | None:
        """Let the agent answer what it was asked, and go on until it is asked again or the episode ends.

        Returns the agent's inputs, None if it ended in a tick in which they were not complete. At the end the tick is
        finished without an action. ``answer``: None at the start.

        Raises
        ------
        StageError
            A stage raised, or returned something invalid: the episode has ended.
        """
        schedule = self.schedule
        try:
            if answer is not None:
                vars(self._agent)["answer"] = answer
                schedule.end(self._inputs)
            while True:
                self._inputs = schedule.begin()
                ends = schedule.outcome
                if ends is None and self._until_us is not None and schedule.next_utime > self._until_us:
                    ends = Outcome.TIMEOUT
                if ends is not None:
                    schedule.end(None)
                    self.outcome = str(ends)
                    return self._inputs
                if self._inputs is not None:
                    return self._inputs
                schedule.end(None)
        except StageError as error:
            self.outcome = str(Outcome.FAILED)
            if self._record is not None:
                self._record.note(error)
            raise

    def metrics(self, names: Collection[str] | None = None) -> dict[str, float]:
        """Return metrics so far as ``stage.metric``; ``names``: of these stages, None for all.

        Raises
        ------
        GraphnavError
            The summary of a stage fails, or holds what it does not declare.
        """
        found: dict[str, float] = {}
        for name, stage in self._stages.items():
            if metrics_of(type(stage)) and (names is None or name in names):
                found |= {f"{name}.{metric}": value for metric, value in _measured(name, stage).items()}
        return found

    def close(self, outcome: str = Outcome.STOPPED) -> None:
        """End it, with the outcome that it has or this one, and complete its record.

        Raises
        ------
        GraphnavError
            A stage does not close, or the record cannot be written.
        """
        if self.is_closed:
            return
        self.is_closed = True
        if self._record is None:
            self.schedule.engine.close()
        else:
            self._record.end(self.outcome or str(outcome))


def _microseconds(seconds: float | None) -> int | None:
    return None if seconds is None else round(seconds * 1e6)


def _measured(name: str, stage: Stage) -> dict[str, float]:
    try:
        return measured_metrics(stage)
    except DeclarationError:
        raise
    except Exception as error:
        raise GraphnavError(f"stage '{name}': summary: {one_line(error)}") from error


class _Record:
    """The run folder of an episode."""

    def __init__(self, graph: Graph, folder: Path) -> None:
        run = replace(graph.run, record=graph.run.record or "replayable")
        self._graph = replace(graph, run=run)
        self._begin_s = time.monotonic()
        self._run = RecordedRun(self._graph, folder, new_run_id(), lambda _: None, self._close_log, self._measured)
        self._run.save_graph()
        try:
            self._writer = self._run.open_log(folder / RunFolder.LOG)
        except OSError as error:
            raise UserError.of(f"record: cannot write into {folder}: {error.strerror}", "choose another") from error
        self._kept = self._run.kept(self._writer, None, is_live=False)
        self._tick = _NewestTick(self._kept)
        self.sinks: Sequence[Sink] = [self._tick]

    def begin(self, schedule: SplitLockstep) -> None:
        """Write the first event."""
        self._schedule = schedule
        self._run.engine = schedule.engine
        self._writer.write(About.CHANNEL, 0, encode(about_of(self._graph), 0, 0))

    def note(self, error: GraphnavError) -> None:
        """Note what a stage raised."""
        with self._run.failures.noted():
            raise error

    def end(self, outcome: str) -> None:
        """Take back the last command, read the scores, and complete log and summary."""
        run, engine = self._run, self._schedule.engine
        run.outcome = outcome
        commands = {channel.name for channel in self._graph.commands}
        with run.failures.noted():
            if self._tick.holds(commands):
                self._tick.release()
            engine.give_stops([self._kept])
            self._tick.release()
        run.read_scores()
        run.failures.close(engine.close)
        run.failures.close(self._close_log)
        run.summarise()

    def _close_log(self) -> None:
        self._writer.close()

    def _measured(self) -> Measured:
        wall_s = time.monotonic() - self._begin_s
        return Measured(sim_s=self._schedule.engine.utime / 1e6, wall_s=wall_s, behind_s=0.0, tap_dropped=0)


class _NewestTick:
    """A sink that holds the messages of the newest tick back, so that stops can stand before it.

    They have the stamp of the last command, and the last tick of an episode has none.
    """

    def __init__(self, sink: Sink) -> None:
        self._sink = sink
        self._utime = 0
        self._held: list[tuple[str, int, bytes]] = []

    def write(self, channel: str, utime: int, data: bytes) -> None:
        """Hold a message; pass on those before if it begins another tick."""
        if utime > self._utime:
            self.release()
            self._utime = utime
        self._held.append((channel, utime, data))

    def holds(self, channels: Collection[str]) -> bool:
        """Whether a message of one of the channels is held."""
        return any(channel in channels for channel, _, _ in self._held)

    def release(self) -> None:
        """Pass on what is held."""
        held, self._held = self._held, []
        for message in held:
            self._sink.write(*message)


def channel_of(graph: Graph, kind: type[Message]) -> Channel | None:
    """Return the channel of a world's messages of a type, None if it has none."""
    written = (channel for node in graph.sources for channel in node.outputs.values())
    return next((channel for channel in written if channel.message is kind), None)
