"""The schedule of live runs whose stages live in other processes, too: their steps overlap."""

from __future__ import annotations

import math
import os
import threading
from collections.abc import Collection, Iterable, Mapping, Sequence
from contextlib import suppress
from typing import NamedTuple

from graphnav import Graph, Stage
from graphnav.core.errors import StageError
from graphnav.core.graph import Node
from graphnav.core.runner import (
    LiveInbox,
    LiveStep,
    ProcessState,
    RemoteProcesses,
    RemoteStage,
    RemoteUnit,
    Sink,
    StageCalls,
    Taken,
    Timer,
    Unit,
)
from graphnav.live.clock import LiveClock
from graphnav.live.inputs.intake import Intake
from graphnav.live.live_schedule import LiveSchedule

_SETTLE_S = 1.0
"""How long steps in other processes may take to end when the run has ended."""


class WakeEvent(threading.Event):
    """An event with a descriptor, which is readable when the event has been set since it was cleared last."""

    def __init__(self) -> None:
        super().__init__()
        self._fd = os.eventfd(0, os.EFD_NONBLOCK | os.EFD_CLOEXEC)
        self._is_open = True
        self._closing = threading.Lock()

    def fileno(self) -> int:
        """Return the descriptor."""
        return self._fd

    def set(self) -> None:
        """Set the event, then make the descriptor readable."""
        super().set()
        with self._closing:
            if self._is_open:
                os.eventfd_write(self._fd, 1)

    def clear(self) -> None:
        """Clear the event, then the descriptor: one that is set meanwhile wakes once too often, and never not."""
        super().clear()
        with suppress(BlockingIOError):
            os.eventfd_read(self._fd)

    def close(self) -> None:
        """Close the descriptor; the event goes on without it."""
        with self._closing:
            self._is_open = False
            os.close(self._fd)


class ToldTimer(Timer):
    """A timer of a source in another process, which tells with the end of each step when the next one is due."""

    def __init__(self, start_s: float) -> None:
        super().__init__(lambda _: math.inf, start_s)
        self._skipped_before = 0

    def advance(self, now_s: float) -> None:  # noqa: ARG002 - the process is told
        """Wait for what the process tells."""
        self.due_s = math.inf

    def run_s(self, now_s: float) -> float:
        """Return the time since its first firing was due."""
        return now_s - self._start_s

    def tell(self, after_s: float, skipped: int) -> None:
        """Take when the next firing is due, after the first one, and how many were skipped since then."""
        self.due_s, self.skipped = self._start_s + after_s, self._skipped_before + skipped

    def lose(self) -> None:
        """Note that the process is gone."""
        self.due_s, self._skipped_before, self.is_lost = math.inf, self.skipped, True

    is_lost = False
    """Whether the process is gone, and no other one was begun with."""

    def begin_again(self, now_s: float) -> None:
        """Restart with another process."""
        self.due_s = self._start_s = now_s
        self.is_lost = False


class _Step(NamedTuple):
    """A step in another process."""

    unit: RemoteUnit[LiveInbox]
    ready_s: float | None
    """When its set of inputs was complete, None for a step on a timer."""
    birth_s: float
    origin_s: float
    call: tuple[str, str, int, Mapping[str, object], float]
    """For `StageCalls`."""


class ProcessSchedule(LiveSchedule):
    """Fires the stages of a live run as `LiveSchedule` does, where some of them live in other processes.

    A stage of another process begins its step and the next turn is taken at once. What it publishes is sent, delivered
    and recorded when the step has ended, in the order in which steps end. Until then the stage is not fired again: the
    newest complete set fires next. A process has one step at a time.

    When a process ends, what was made from its messages is dropped as for an input that restarts, and steps in progress
    with such messages are recorded, but neither sent nor delivered. Its stages are reset by the new process.
    """

    def __init__(
        self,
        graph: Graph,
        stages: Mapping[str, Stage],
        clock: LiveClock,
        intakes: Sequence[Intake],
        wake: WakeEvent,
        sinks: Sequence[Sink],
        firings: Sink | None,
        calls: StageCalls,
        processes: RemoteProcesses,
        remote: Mapping[str, RemoteStage],
    ) -> None:
        super().__init__(graph, {**stages, **remote}, clock, intakes, wake, sinks, firings, calls)
        self._processes, self._calls = processes, calls
        self._remote = [unit for unit in self.engine.units.values() if isinstance(unit, RemoteUnit)]
        self._flying: dict[str, _Step] = {}
        """The steps in progress by stage, the oldest first."""
        self._dropped: set[str] = set()
        """The stages among them whose results are not used."""
        self._held: frozenset[str] = frozenset()
        """The stages that begin no step, for a change."""
        self._has_stepped = self._is_put_off = False
        """Whether the last turn stepped a stage of this process: its readers begin before others are heard."""
        processes.watch(wake.fileno())

    @property
    def process_states(self) -> Sequence[ProcessState]:
        """How the processes of its stages are."""
        return self._processes.states()

    def reset(self, seed: int) -> None:
        """Reset the state of every stage from ``seed``, those of other processes at once.

        Raises
        ------
        StageError
            A stage cannot be reset.
        """
        self._processes.order_reset(seed, self.clock.start_utime)
        super().reset(seed)
        self._processes.take_lost()

    def behind_s(self, now_s: float) -> float:
        """Return the lateness of the latest source or timer whose process is there, in seconds."""
        timers = [
            t for t, unit in (*self._clocked, *self._sources) if unit.node.name in self.steps or self._is_free(unit)
        ]
        return max([0.0, *(now_s - timer.due_s for timer in timers)])

    def hold(self, stages: Collection[str]) -> bool:
        """Begin no step of these stages until the next change; return whether they make none at the moment."""
        self._held = frozenset(stages)
        return self._held.isdisjoint(self._flying)

    def change(self, graph: Graph, nodes: Iterable[Node], stages: Mapping[str, Stage]) -> list[StageError]:
        """Let other stages take over from their next firing on, as `Engine.change` does; ``graph``: with them."""
        self._held = frozenset()
        return super().change(graph, nodes, stages)

    def settle(self) -> None:
        """Wait a little for steps that have not ended when the run has; what they publish goes to the log alone."""
        try:
            self._dropped.update(self._flying)
            self._await_steps(self.clock.now_s() + _SETTLE_S)
        finally:
            self._processes.interrupt()
            self._flying.clear()
            self.steps.clear()
            self._calls.wait_for(None)

    def is_away(self, stage: str) -> bool:
        """Whether the process of a stage is being started again."""
        unit = self.engine.units[stage]
        return isinstance(unit, RemoteUnit) and not unit.is_there

    def _is_free(self, unit: Unit[LiveInbox]) -> bool:
        if unit.node.name in self._held:
            return False
        return unit.is_free if isinstance(unit, RemoteUnit) else True

    def _source_timer(self, unit: Unit[LiveInbox], start_s: float) -> Timer:
        return ToldTimer(start_s) if isinstance(unit, RemoteUnit) else super()._source_timer(unit, start_s)

    def _wait(self, timeout_s: float) -> None:
        self._note_oldest()
        if not self._wake.is_set():
            self._processes.wait(timeout_s)

    def _note_oldest(self) -> None:
        """Let other threads see the step that this one has waited for longest."""
        self._calls.wait_for(next(iter(self._flying.values())).call if self._flying else None)

    def _take_results(self) -> str | None:
        self._is_put_off, self._has_stepped = self._has_stepped and not self._is_put_off, False
        if not self._is_put_off:
            self._processes.wait(0.0)
        outcome = self._take_ended()
        self._raise_if_down()
        now_s = self.clock.now_s()
        for timer, unit in self._sources:
            if isinstance(timer, ToldTimer) and timer.is_lost and self._is_free(unit):
                timer.begin_again(now_s)
        return outcome

    def _raise_if_down(self) -> None:
        """Raise StageError if a process is gone for good."""
        for remote in self._remote:
            remote.raise_if_down(self.clock.now())

    def _take_ended(self) -> str | None:
        """Drop what was made from processes that have ended, and publish what steps that have ended returned."""
        if lost := self._processes.take_lost():
            self._lose(lost)
        outcome = None
        for step in [step for step in self._flying.values() if step.unit.is_done]:
            outcome = self._end(step) or outcome
        return outcome

    def _step(self, unit: Unit[LiveInbox], utime: int, taken: Taken, ready_s: float | None) -> str | None:
        if not isinstance(unit, RemoteUnit):
            self._has_stepped = True
            return super()._step(unit, utime, taken, ready_s)
        name, now_s = unit.node.name, self.clock.now_s()
        timer = next((timer for timer, source in self._sources if source is unit), None)
        run_s = timer.run_s(now_s) if isinstance(timer, ToldTimer) else None
        numbers = tuple(self.engine.next_number(channel.name) for channel in unit.node.outputs.values())
        call = name, "step", utime, taken.inputs, now_s
        self._flying[name] = _Step(unit, ready_s, unit.inbox.birth_s, unit.inbox.origin_s, call)
        self.steps[name] = now_s
        unit.begin(utime, taken.inputs, LiveStep(taken.age_s, numbers, run_s))
        return None

    def _end(self, step: _Step) -> str | None:
        """Publish what a step returned; return the outcome if a source ended the run."""
        unit, name = step.unit, step.unit.node.name
        del self._flying[name], self.steps[name]
        self._birth_s, self._origin_s = step.birth_s, step.origin_s
        is_dropped = name in self._dropped
        self._dropped.discard(name)
        unit.deliver(is_dropped=is_dropped)
        if step.ready_s is not None:
            unit.judge_deadline(step.ready_s, self.clock.now_s())
        outcome = unit.commit()
        for timer, source in self._sources:
            if source is unit and isinstance(timer, ToldTimer) and outcome is None:
                timer.tell(*unit.next_due())
        return outcome

    def _lose(self, names: Collection[str]) -> None:
        """Drop the steps of stages whose processes have ended, and what was made from their messages."""
        for name in names:
            self._flying.pop(name, None)
            self.steps.pop(name, None)
            self._dropped.discard(name)
            self.engine.units[name].inbox.restart()
        for timer, unit in self._sources:
            if isinstance(timer, ToldTimer) and unit.node.name in names:
                timer.lose()
        self._restart(channel.name for name in names for channel in self.engine.units[name].node.outputs.values())

    def _drop(self, unit: Unit[LiveInbox]) -> None:
        super()._drop(unit)
        if unit.node.name in self._flying:
            self._dropped.add(unit.node.name)

    def _fire_timer(self, unit: Unit[LiveInbox], now_s: float) -> str | None:
        if self._is_free(unit):
            return super()._fire_timer(unit, now_s)
        for timer, clocked in self._clocked:
            if clocked is unit:  # as soon as its process has time
                timer.due_s = min(timer.due_s, now_s)
        return None

    def _finish(self) -> None:
        self.hold(())
        end_s = self.clock.now_s() + _SETTLE_S
        self._await_steps(end_s)
        for unit in reversed(self._order):
            if self._is_free(unit) and (matched := unit.inbox.ready(math.inf, unit.patience_s)) is not None:
                self._fire_set(unit, matched, self.clock.now_s())
                self._await_steps(end_s)
        self._raise_if_down()

    def _await_steps(self, end_s: float) -> None:
        while self._flying and (left_s := end_s - self.clock.now_s()) > 0:
            self._note_oldest()
            self._processes.wait(left_s)
            self._take_ended()
