"""A unit of the engine whose stage lives in another process: messages go to it and come from it as bytes."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager
from typing import Any, Literal, NamedTuple, Protocol

from graphnav.core.errors import GraphnavError, Problem, StageError, failure_line
from graphnav.core.graph import Channel, Graph, Node
from graphnav.core.runner.stage_calls import StageCalls
from graphnav.core.runner.unit import I, Unit

Deliver = Callable[[Channel, int, int, bytes], None]
Record = Callable[[Channel, int, bytes], None]


class Encoded:
    """A message as its bytes, as an input of a stage of another process.

    ``place``: where what feeds such a stage again keeps them, -1 where it does not.
    """

    __slots__ = ("data", "place")

    def __init__(self, data: bytes) -> None:
        self.data = data
        self.place = -1


class Done(NamedTuple):
    """Result of one step of a stage of another process."""

    outputs: tuple[tuple[str, int, bytes], ...] = ()
    """Messages that it published until it ended or failed: port, stamp and bytes."""
    outcome: str | None = None
    """Where a source ended the run."""
    error: GraphnavError | None = None
    took_s: float | None = None
    """None if the step itself failed."""
    due: int | GraphnavError | None = None
    """Of a source: when its next firing is due, microseconds, or why that is not known."""
    skipped: int = 0
    """Of a source, live: firings skipped since the first one, because they were late by more than a period."""


class LiveStep(NamedTuple):
    """Parts of a step of a live run beside its stamp and its inputs."""

    age_s: float
    """Of its plain inputs."""
    numbers: tuple[int, ...]
    """Of the next message of each output."""
    run_s: float | None = None
    """Of a source: the time since its first firing was due."""


class RemoteStage(Protocol):
    """A stage of another process, as this one calls it."""

    patience_s: float
    """How long a live firing waits for `Since` inputs, known when it is reset."""

    @property
    def is_done(self) -> bool:
        """Whether what became of the step that was begun has arrived."""

    @property
    def is_free(self) -> bool:
        """Whether its process is there, has been reset and has nothing to do, so that a step would begin at once."""

    @property
    def is_there(self) -> bool:
        """Whether its process is there and has been reset."""

    @property
    def restarts(self) -> int:
        """How often its process was started again."""

    def failure(self, at_s: float) -> StageError | None:
        """Return why its process is gone for good, None if it is not."""

    def reset(self) -> None:
        """Wait until the stage is reset, as was ordered for all; raises StageError if it cannot be."""

    def begin(self, utime: int, inputs: Mapping[str, Any], live: LiveStep | None) -> None:
        """Begin a step; messages among the inputs are `Encoded`. ``live``: None in lockstep."""

    def done(self) -> Done:
        """Wait for the end of the step that was begun."""

    def prepare(self, graph: Graph) -> None:
        """Begin to make and reset the stage as another graph has it, beside the one that steps."""

    def prepared(self) -> Sequence[Problem] | None:
        """Return why what was prepared cannot take over, empty if it can, None while that is not known."""

    def drop_prepared(self) -> None:
        """Forget what was prepared: it does not take over."""

    def change(self, graph: Graph, utime: int) -> None:
        """Let what was prepared make all further steps; ``utime``: the clock."""

    def unclosed(self) -> Sequence[StageError] | None:
        """Return what the stage before the last change raised when it was closed, None while that is not known."""

    def metrics(self) -> dict[str, float] | None:
        """Return the metrics of the stage, None if it reports none or its process is gone; raises StageError."""

    def close(self, at_s: float) -> None:
        """Close the stage, if its process is still there; raises StageError."""


class ProcessState(NamedTuple):
    """A process of a run, and the stages that live in it.

    ``host``: on which it lives, empty for this machine; the others: what the run knows of that host's clock, NaN while
    it is not known, as in ``process_status_t``.
    """

    name: str
    stages: tuple[str, ...]
    pid: int
    """0 while there is none."""
    state: Literal["starting", "ready", "restarting", "given up"]
    restarts: int
    host: str = ""
    round_trip_ms: float = math.nan
    clock_offset_s: float = math.nan
    clock_error_s: float = math.nan
    clock_drift_ppm: float = math.nan
    clock_steps: int = 0


class RemoteProcesses(Protocol):
    """The processes of the stages of a live run."""

    def order_reset(self, seed: int, begin_us: int = 0) -> None:
        """Let all processes begin to reset their stages by the seed of the run, and its clock at the start."""

    def wait(self, timeout_s: float | None = None) -> None:
        """Wait for something to happen to the processes or to what is watched, and handle it."""

    def watch(self, fd: int) -> None:
        """Let `wait` also return when a descriptor is readable."""

    def take_lost(self) -> Collection[str]:
        """Return the stages whose processes have ended since the last call."""

    def interrupt(self) -> None:
        """Break off the steps in progress, end the processes that do not obey, and start none any more."""

    def states(self) -> Sequence[ProcessState]:
        """Return how the processes are at the moment."""

    def report(self) -> dict[str, Any]:
        """Return what became of the processes, for the summary."""


class RemoteUnit(Unit[I]):
    """A stage of another process.

    ``deliver`` gives a message to its readers: channel, stamp of the firing, stamp of the message, bytes; it raises
    ValueError where the stamp does not fit. ``record`` gives it to the log and the tap: channel, stamp, bytes.

    A step has three parts, so that steps of several processes overlap: `begin`, `deliver` when it `is_done`, and
    `commit` in the firing order, which records and raises. `step` does all three.
    """

    def __init__(
        self,
        node: Node,
        remote: RemoteStage,
        inbox: I,
        deliver: Deliver,
        record: Record,
        calls: StageCalls,
        start_utime: int,
    ) -> None:
        super().__init__(node, inbox, start_utime)
        self._remote, self._deliver, self._record, self._calls = remote, deliver, record, calls
        self._begun: tuple[int, Mapping[str, Any]] = start_utime, {}
        self._done = Done()
        self._n_fired = 0

    @property
    def is_done(self) -> bool:
        """Whether the step that was begun has ended."""
        return self._remote.is_done

    @property
    def is_free(self) -> bool:
        """Whether a step would begin at once."""
        return self._remote.is_free

    @property
    def is_there(self) -> bool:
        """Whether its process is there and has been reset."""
        return self._remote.is_there

    @property
    def restarts(self) -> int:
        """How often its process was started again."""
        return self._remote.restarts

    def raise_if_down(self, utime: int) -> None:
        """Raise StageError if its process is gone for good."""
        if (error := self._remote.failure((utime - self.start_utime) / 1e6)) is not None:
            raise error

    def begin(self, utime: int, inputs: Mapping[str, Any], live: LiveStep | None = None) -> None:
        """Begin a step with ``inputs`` by port."""
        self._begun = utime, inputs
        self._remote.begin(utime, inputs, live)

    def waiting(self) -> AbstractContextManager[None]:
        """Return a context in which other threads see that this one waits for the step that was begun."""
        return self._noted("step", *self._begun)

    def deliver(self, *, is_dropped: bool = False) -> None:
        """Wait for the end of the step, and give what it published to the stages that read it, unless it is dropped."""
        self._done = self._remote.done()
        if is_dropped:
            return
        stamp = self._begun[0]
        for place, (port, utime, data) in enumerate(self._done.outputs):
            try:
                self._deliver(self.node.outputs[port], stamp, utime, data)
            except ValueError as error:
                what = f"output '{port}': {failure_line(error)}"
                failure = StageError(self.node.name, self.node.use, (stamp - self.start_utime) / 1e6, what)
                failure.__cause__ = error
                self._done = self._done._replace(outputs=self._done.outputs[:place], error=failure)
                break

    def commit(self) -> str | None:
        """Record what the step published; return the outcome if a source ended the run; raises what it raised."""
        self.last_utime = self._begun[0]
        self._n_fired += 1
        if self._done.took_s is not None:
            self.durations.add(self._done.took_s)
        for port, utime, data in self._done.outputs:
            self._record(self.node.outputs[port], utime, data)
        if self._done.error is not None:
            raise self._done.error
        return self._done.outcome

    def step(self, utime: int, inputs: dict[str, Any], age_s: float = 0.0) -> str | None:  # noqa: ARG002 - 0 in lockstep
        """Step once with ``inputs`` by port and publish; return the outcome if a source ended the run."""
        self.begin(utime, inputs)
        with self.waiting():
            self.deliver()
        return self.commit()

    def reset(self, run_seed: int, seed: int) -> None:  # noqa: ARG002 - its process was told, and derives the other
        """Wait until the stage is reset; raises StageError if it cannot be."""
        self._n_fired = 0
        with self._noted("reset", self.start_utime, {}):
            self._remote.reset()

    def due_us(self, firing: int) -> int:
        """Return when the next firing of a source is due, which came with the end of its step."""
        assert firing == self._n_fired, "asked after each step for the next one"
        due = self._done.due
        if isinstance(due, GraphnavError):
            raise due
        assert due is not None, "only sources are asked"
        return due

    def next_due(self) -> tuple[float, int]:
        """Return when a source of a live run is due next, seconds after its first firing, and how many it skipped."""
        return self.due_us(self._n_fired) / 1e6, self._done.skipped

    def patience_s(self) -> float:
        """Return how long a live firing waits for `Since` inputs."""
        return self._remote.patience_s

    def prepare(self, graph: Graph) -> None:
        """Begin to make and reset the stage as another graph has it, beside the one that steps."""
        self._remote.prepare(graph)

    def prepared(self) -> Sequence[Problem] | None:
        """Return why what was prepared cannot take over, empty if it can, None while that is not known."""
        return self._remote.prepared()

    def drop_prepared(self) -> None:
        """Forget what was prepared: it does not take over."""
        self._remote.drop_prepared()

    def change(self, graph: Graph, node: Node, inbox: I, utime: int) -> None:
        """Let what was prepared make all further steps; ``utime``: the clock."""
        self._remote.change(graph, utime)
        inbox.adopt(self.inbox)
        self.node, self.inbox = node, inbox

    def unclosed(self) -> Sequence[StageError] | None:
        """Return what the stage before the last change raised when it was closed, None while that is not known."""
        return self._remote.unclosed()

    def metrics(self) -> dict[str, float] | None:
        """Return the metrics of the stage after a run, None if it reports none or its process is gone."""
        with self._noted("summary", self.last_utime, {}):
            return self._remote.metrics()

    def close(self, at_s: float) -> None:
        """Close the stage; raises StageError if it raises."""
        with self._noted("close", self.last_utime, {}):
            self._remote.close(at_s)

    @contextmanager
    def _noted(self, method: str, utime: int, inputs: Mapping[str, Any]) -> Iterator[None]:
        """Note for other threads that this one waits for a call into the stage."""
        self._calls.begin(self.node.name, method, utime, inputs)
        try:
            yield
        finally:
            self._calls.end()
