"""The schedule of a live log: it repeats the recorded firings; every step gets the same messages as in the run."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from typing import Any, NamedTuple

from graphnav import Message, Recording, Stage
from graphnav.core.codec import decode
from graphnav.core.graph import Node
from graphnav.core.runner import Engine, LiveInbox, Sink, Taken, Timer, Unit, Used
from graphnav.core.stage import Port
from graphnav.replay.log.changes import MadeChange
from graphnav.replay.log.contents import Logged
from graphnav.replay.log.firings import Firing, LoggedFirings
from graphnav.replay.plan import Plan
from graphnav.replay.stepping.firing_log import FiringLog
from graphnav.replay.stepping.recorded_inbox import Read, RecordedInbox
from graphnav.replay.stepping.repeated_changes import RepeatedChanges

_MAX_GAP_S = 10.0
"""Timers do not fire in longer gaps of a log, whose timestamps may be damaged."""


class FiringReplay:
    """Fires the stepping stages in log order.

    Messages of played channels come from the log, those of stepping stages are the newly published ones of the same
    timestamp. A firing is skipped if a message of a plain input was not published again. Stages that the run did not
    have fire by the rule of `AddedStages`; inputs that a stage did not read in the run are new ports. ``begin_us``,
    ``start_us``: the run's clock at its start, and the time from which stages fire. ``log`` receives everything that is
    needed to replay this replay. ``changes``: of stages while the run went on.
    """

    def __init__(
        self,
        plan: Plan,
        stages: Mapping[str, Stage],
        recording: Recording,
        logged: LoggedFirings,
        sinks: Sequence[Sink],
        log: FiringLog | None,
        begin_us: int,
        start_us: int,
        changes: Sequence[MadeChange] = (),
    ) -> None:
        self._recording, self._logged, self._log = recording, logged, log
        self._queues = plan.graph.queues
        self._start_us = start_us
        self._messages = {channel.name: channel.message for channel in plan.graph.channels.values()}
        self._awaited = logged.awaited.copy()
        self._own_us = begin_us
        self._birth_s = 0.0
        self.engine: Engine[Any] = Engine(
            plan.stepped_at_first.order,
            stages,
            sinks if log is None else (*sinks, log),
            self._inbox,
            self._arrived,
            played={channel.name for channel in plan.played},
            begin_us=begin_us,
        )
        self.reset, self.close = self.engine.reset, self.engine.close
        self._changes = RepeatedChanges(changes, self.engine, () if log is None else (log,))
        if log is not None:
            log.now_us = lambda: self.engine.utime
        self._heard = {
            name
            for name, readers in self.engine.readers.items()
            if any(self._hears(unit.node, port.name) for unit, port in readers)
        }
        """The channels that added stages and new ports read."""
        added = [unit for unit in self.engine.units.values() if unit.node.name in logged.added]
        self._added = AddedStages(added, self._run_s(start_us))

    def _inbox(self, node: Node) -> LiveInbox | RecordedInbox:
        if node.name in self._logged.added:
            return LiveInbox(node, self._queues)
        new = [i.port for i in node.inputs if i.channel is not None and self._hears(node, i.port.name)]
        return RecordedInbox(node, self._awaited, self._played, new)

    def _hears(self, node: Node, port: str) -> bool:
        """Whether the run did not read this input."""
        return node.name in self._logged.added or (node.name, port) in self._logged.new_ports

    def replay(self) -> Iterator[int]:
        """Repeat the firings; yield the run's clock after each one, microseconds.

        Raises
        ------
        StageError
            A stage raised, or returned an invalid value.
        DecodeError
            A message of the log is damaged.
        """
        for one in self._events():
            if one.at_us >= self._start_us:
                yield from self._fire_added(one.at_us)
            self.engine.utime = one.at_us
            self._changes.make(one.at_us)
            if isinstance(one, Logged):
                self._hear(one)
            elif one.stage not in self.engine.units:
                self._copy(one)
            elif one.at_us >= self._start_us and one.stage not in self._logged.added:
                self.engine.ticks += self._repeat(one)
                yield one.at_us
            if one.at_us >= self._start_us:
                yield from self._fire_added(one.at_us)

    def _events(self) -> Iterator[Logged | Firing]:
        """Yield the firings, each one preceded by the messages up to then that are read or copied."""
        is_wanted = self._heard.__contains__ if self._log is None else lambda _: True
        messages = [one for one in self._logged.messages if is_wanted(one.channel)]
        place = 0
        for firing in self._logged.firings:
            while place < len(messages) and messages[place].at_us <= firing.at_us:
                yield messages[place]
                place += 1
            yield firing
        if not self._logged.is_cut:
            yield from messages[place:]

    def _fire_added(self, to_us: int) -> Iterator[int]:
        while self._logged.added and (due := self._added.next_due(self._run_s(to_us))) is not None:
            self.engine.utime = self.engine.begin_us + round(due.at_s * 1e6)
            stamp = self._stamp_of(due)
            if (taken := due.take()) is not None:
                self._birth_s = due.unit.inbox.birth_s
                self._log_firing(due.unit.node.name, stamp, taken)
                self.engine.fire(due.unit, stamp, taken.inputs, taken.age_s)
            self.engine.ticks += 1
            yield self.engine.utime

    def _stamp_of(self, due: Due) -> int:
        if due.utime is not None:
            return due.utime
        self._own_us = max(self._own_us + 1, self.engine.utime)
        return self._own_us

    def _run_s(self, at_us: int) -> float:
        return (at_us - self.engine.begin_us) / 1e6

    def _hear(self, logged: Logged) -> None:
        """Process a message of the log."""
        data = self._recording.event(logged.channel, logged.place).data
        number = logged.place if self._log is None else self._log.copy(logged, data)
        if logged.channel in self._heard:
            message = decode(self._messages[logged.channel], data)[2]
            self._birth_s = self._run_s(logged.at_us)
            self.engine.deliver(logged.channel, logged.utime, number, message)

    def _arrived(self, inbox: LiveInbox | RecordedInbox, port: Port, utime: int, number: int, message: Message) -> None:
        """Put a message into an inbox; before the start only if it is sampled."""
        if port.latest or self.engine.utime >= self._start_us:
            inbox.put(port, utime, number, message, self._birth_s, self._run_s(self.engine.utime))

    def _repeat(self, firing: Firing) -> bool:
        """Repeat a firing; return whether the stage stepped, False if a message of a plain input was not published."""
        unit = self.engine.units[firing.stage]
        now_s = self._run_s(firing.at_us)
        taken = unit.inbox.take(firing, now_s)
        if taken is None:
            return False
        is_decision = unit.node.every_ms is not None or not math.isfinite(firing.age_s)
        self._birth_s = now_s if is_decision else now_s - firing.age_s
        try:
            self.engine.fire(unit, firing.utime, taken.inputs, firing.age_s)
        finally:
            self._log_firing(firing.stage, firing.utime, taken)
        return True

    def _played(self, channel: str, used: Used) -> Read:
        """Return a message of the log that a firing read."""
        logged = self._logged.played[channel, used.number, used.utime]
        message = decode(self._messages[channel], self._recording.event(channel, logged.place).data)[2]
        return Read(message, self._log.number_of(channel, logged.place) if self._log else used.number)

    def _log_firing(self, stage: str, utime: int, taken: Taken) -> None:
        if self._log is not None:
            self._log.fire(stage, self.engine.utime, utime, taken)

    def _copy(self, firing: Firing) -> None:
        """Write the firing of a stage that does not step, so that a replay of this replay can step it."""
        if self._log is None:
            return
        channels = self._logged.channels.get(firing.stage, {})
        used = [one._replace(number=self._log.number_of(channels.get(one.port, ""), one.number)) for one in firing.used]
        self._log.fire(firing.stage, firing.at_us, firing.utime, Taken({}, firing.age_s, used))


class Due(NamedTuple):
    """A firing: its time, seconds of the run, and the stage."""

    at_s: float
    unit: Unit[LiveInbox]
    utime: int | None
    """The timestamp of its set of inputs, None if it publishes with the run's clock."""
    take: Callable[[], Taken | None]
    """Returns what it steps with, None if it does not step."""


class AddedStages:
    """Determines the next stage to fire, by log time.

    Steps take no time, so a stage fires at the time of the message that completes the newest set of its plain inputs,
    stages near the end of the graph first; later if the set waits for a `Since` input. Timers start at ``start_s``.
    """

    def __init__(self, units: Sequence[Unit[LiveInbox]], start_s: float) -> None:
        self._units = tuple(reversed(units))
        self._timers = [(Timer(Timer.every(u.node.every_ms / 1e3), start_s), u) for u in self._units if u.node.every_ms]
        self._now_s = start_s

    def next_due(self, to_s: float) -> Due | None:
        """Return the next firing up to a time, None if there is none."""
        for unit in self._units:
            if (due := self._ready(unit, self._now_s)) is not None:
                return due
        self._skip_gap(to_s)
        timer_s, timer, clocked = min(
            ((timer.due_s, timer, unit) for timer, unit in self._timers),
            key=lambda one: one[0],
            default=(math.inf, None, None),
        )
        waking_s = min((unit.inbox.wakes_at_s(unit.patience_s) for unit in self._units), default=math.inf)
        if min(timer_s, waking_s) > to_s:
            self._now_s = max(self._now_s, to_s)
            return None
        self._now_s = max(self._now_s, min(timer_s, waking_s))
        if timer is None or clocked is None or waking_s < timer_s:
            return self.next_due(to_s)
        timer.advance(self._now_s)
        return Due(self._now_s, clocked, None, partial(clocked.inbox.take_timer, self._now_s, clocked.patience_s))

    def _ready(self, unit: Unit[LiveInbox], now_s: float) -> Due | None:
        matched = unit.inbox.ready(now_s, unit.patience_s)
        if matched is None:
            return None
        utime = None if unit.inbox.is_clocked else matched.utime
        return Due(now_s, unit, utime, partial(unit.inbox.take_set, matched, now_s))

    def _skip_gap(self, to_s: float) -> None:
        for timer, _ in self._timers:
            if to_s - timer.due_s > _MAX_GAP_S:
                timer.advance(to_s)
