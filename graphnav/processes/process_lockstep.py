"""The schedule of lockstep over processes: the same firings, published in the same order, but side by side."""

from __future__ import annotations

import heapq
from collections import Counter, deque
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from enum import Enum, auto
from time import perf_counter
from typing import Any

from graphnav import Graph, Stage
from graphnav.core.errors import StageError
from graphnav.core.graph import Node
from graphnav.core.runner import (
    Lockstep,
    LockstepInbox,
    ProcessState,
    RemoteStage,
    RemoteUnit,
    Sink,
    Spans,
    StageCalls,
    Unit,
)
from graphnav.processes.supervisor import Supervisor


class State(Enum):
    """Where a stage is within a tick."""

    WAITING = auto()
    FIRED = auto()
    DELIVERED = auto()
    """Its step has ended, and its readers have what it published; the log does not yet."""
    IDLE = auto()
    """It does not fire in this tick."""


class ProcessLockstep(Lockstep):
    """Fires the stages of a graph tick by tick as `Lockstep` does, where some of them live in other processes.

    A stage sees what those before it in the firing order have published, and nothing of those behind it. So it fires as
    soon as all stages that it reads from and that are before it have ended their steps, and all that are before it and
    read from it have taken their inputs. What it publishes goes to its readers at once, but into the log in its turn.

    Stages of this process fire in their turn. So do those that report metrics: if a stage before them fails, they must
    not have seen the tick.
    """

    def __init__(
        self,
        graph: Graph,
        stages: Mapping[str, Stage | RemoteStage],
        sinks: Sequence[Sink],
        spans: Spans | None,
        calls: StageCalls,
        supervisor: Supervisor,
    ) -> None:
        super().__init__(graph, stages, sinks, spans, calls)
        self._supervisor = supervisor
        supervisor.while_waiting = self._look
        self._left: list[int] = []
        """For each stage, how many of those that it waits for in this tick are left."""
        self._states: list[State] = []
        self._flying: dict[int, float] = {}
        """The stages that make a step in other processes, and when they began."""
        self._free: deque[int] = deque()
        self._arrange()

    def _arrange(self) -> None:
        """Find for each stage what its steps wait for."""
        self._units: list[Unit[LockstepInbox]] = [*self._sources, *self._order]
        n = len(self._units)
        places = {unit.node.name: place for place, unit in enumerate(self._units)}
        reads = [{places[i.channel.stage] for i in unit.node.inputs if i.channel is not None} for unit in self._units]
        self._after_end = [[p for p in range(place + 1, n) if place in reads[p]] for place in range(n)]
        """For each stage, those behind it that read from it."""
        self._after_take = [[p for p in range(place + 1, n) if p in reads[place]] for place in range(n)]
        """For each stage, those behind it that it reads from: it gets what they published a tick before."""
        followers = Counter(p for after in (*self._after_end, *self._after_take) for p in after)
        self._n_before = [followers[place] for place in range(n)]
        self._in_turn = [
            not isinstance(unit, RemoteUnit) or unit.node.stage_class.summary is not Stage.summary
            for unit in self._units
        ]

    def change(self, graph: Graph, nodes: Iterable[Node], stages: Mapping[str, Stage]) -> list[StageError]:
        """Let other stages take over from the next tick on, as `Engine.change` does; ``graph``: with them."""
        failed = super().change(graph, nodes, stages)
        self._arrange()
        return failed

    def _look(self) -> None:
        """Call what the run has set by now."""
        self.while_waiting()

    @property
    def process_states(self) -> Sequence[ProcessState]:
        """How the processes of its stages are."""
        return self._supervisor.states()

    @property
    def processes(self) -> dict[str, Any]:
        """Fate of the processes of its stages, for the summary."""
        return self._supervisor.report()

    def reset(self, seed: int) -> None:
        """Reset the state of every stage from ``seed``, those of other processes at once, and the clock to 0.

        Raises
        ------
        StageError
            A stage cannot be reset.
        """
        with self._interrupting():
            self._supervisor.order_reset(seed)
            super().reset(seed)

    def run(self, until_s: float | None = None, before_tick: Callable[[int], bool] = lambda _: True) -> str:
        """Tick as `Lockstep.run` does; where the user does not wait for the end of a tick, break off its steps."""
        with self._interrupting():
            return super().run(until_s, before_tick)

    @contextmanager
    def _interrupting(self) -> Iterator[None]:
        try:
            yield
        except KeyboardInterrupt:
            self._supervisor.interrupt()
            raise

    def _tick(self) -> str | None:
        self.engine.utime = stamp = self._due[0][0]
        due: dict[int, int] = {}
        while self._due and self._due[0][0] == stamp:
            _, place, k = heapq.heappop(self._due)
            due[place] = k
        self._begin(due)
        outcome = None
        for place in range(len(self._units)):
            if place < len(self._sources) and place not in due:
                continue
            outcome = self._finish(place, stamp) or outcome
            if place in due:
                heapq.heappush(self._due, (self._sources[place].due_us(due[place] + 1), place, due[place] + 1))
        self.engine.ticks += 1
        return outcome

    def _begin(self, due: Collection[int]) -> None:
        """Begin a tick in which these sources are due."""
        self._left = self._n_before.copy()
        self._states = [State.WAITING] * len(self._units)
        self._flying.clear()
        self._free = deque(place for place, left in enumerate(self._left) if not left)
        for place in range(len(self._sources)):
            if place not in due:
                self._states[place] = State.IDLE
                self._release(self._after_take[place])
                self._release(self._after_end[place])

    def _finish(self, place: int, stamp: int) -> str | None:
        """Let a stage fire whose turn it is, if it has not begun to, and record what it publishes."""
        self._fire_free(stamp)
        unit = self._units[place]
        if not isinstance(unit, RemoteUnit):
            return self._fire_here(place, unit, stamp)
        if self._states[place] is State.WAITING:
            self._take(place, unit, stamp)
            self._fire_free(stamp)
        if self._states[place] is State.IDLE:
            unit.inbox.discard()
            return None
        if self._states[place] is State.FIRED:
            with unit.waiting():
                while self._collect(stamp) and self._states[place] is State.FIRED:
                    self._supervisor.wait()
        return unit.commit()

    def _fire_here(self, place: int, unit: Unit[LockstepInbox], stamp: int) -> str | None:
        outcome = None
        if place < len(self._sources):
            outcome = self.engine.fire_at(unit, stamp)
        else:
            self.engine.fire_complete(unit, stamp)
        self._states[place] = State.DELIVERED
        self._release(self._after_take[place])
        self._release(self._after_end[place])
        return outcome

    def _fire_free(self, stamp: int) -> None:
        """Fire all that wait for nothing."""
        while self._free:
            place = self._free.popleft()
            unit = self._units[place]
            if isinstance(unit, RemoteUnit) and not self._in_turn[place] and self._states[place] is State.WAITING:
                self._take(place, unit, stamp)

    def _take(self, place: int, unit: RemoteUnit[LockstepInbox], stamp: int) -> None:
        """Begin the step of a stage, unless its inputs are incomplete: these are dropped in its turn."""
        if place < len(self._sources) or unit.inbox.is_complete:
            self._states[place] = State.FIRED
            self._flying[place] = perf_counter()
            unit.begin(stamp, unit.inbox.take(stamp))
        else:
            self._states[place] = State.IDLE
            self._release(self._after_end[place])
        self._release(self._after_take[place])

    def _collect(self, stamp: int) -> bool:
        """Give what ended steps have published to its readers, and fire those that waited for it; return True."""
        for place in [place for place in self._flying if self._is_done(place)]:
            unit = self._units[place]
            assert isinstance(unit, RemoteUnit), "only those fly"
            unit.deliver()
            unit.judge_deadline(self._flying.pop(place), perf_counter())
            self._states[place] = State.DELIVERED
            self._release(self._after_end[place])
        self._fire_free(stamp)
        return True

    def _is_done(self, place: int) -> bool:
        unit = self._units[place]
        return isinstance(unit, RemoteUnit) and unit.is_done

    def _release(self, followers: Collection[int]) -> None:
        """Note that stages wait for one less."""
        for place in followers:
            self._left[place] -= 1
            if not self._left[place]:
                self._free.append(place)
