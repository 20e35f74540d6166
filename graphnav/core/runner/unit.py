"""Run one stage: step, publish the outputs, measure the time."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from time import perf_counter
from typing import Any, Generic, Protocol, TypeVar

from graphnav.core.codec import not_finite
from graphnav.core.errors import (
    GraphnavError,
    StageError,
    failure_line,
    message_line,
    one_line,
    raised_line,
    shown_value,
)
from graphnav.core.graph import Channel, Node
from graphnav.core.interrupts import CtrlC
from graphnav.core.messages import Message
from graphnav.core.runner.durations import Durations
from graphnav.core.runner.stage_calls import StageCalls
from graphnav.core.stage import (
    Finished,
    LiveSource,
    Port,
    Source,
    Stage,
    Stamped,
    ports_of,
    reported_metrics,
    tell_run_seed,
)

Publish = Callable[[Channel, int, Message], None]


class Inbox(Protocol):
    """Holds the messages that arrived for a stage until it fires."""

    @property
    def dropped(self) -> int:
        """Number of inputs that arrived but were never used in a step."""

    def adopt(self, before: Any) -> None:
        """Take what waits for the stage before on inputs that read the same channel alike, and its counts."""


I = TypeVar("I", bound=Inbox)  # noqa: E741 - the inbox


class Unit(ABC, Generic[I]):
    """A stage of an engine: its inbox, its counters, and the calls into it.

    ``start_utime``: start of the run, by the clock of its stamps.
    """

    def __init__(self, node: Node, inbox: I, start_utime: int) -> None:
        self.node, self.inbox = node, inbox
        self.durations = Durations()
        self.missed = 0
        """Number of steps that ended after the stage's deadline."""
        self.last_utime = self.start_utime = start_utime

    def judge_deadline(self, ready_s: float, done_s: float) -> None:
        """Count a step that missed the stage's deadline; times in seconds."""
        if self.node.deadline_ms is not None and done_s - ready_s > self.node.deadline_ms / 1e3:
            self.missed += 1

    @property
    def restarts(self) -> int:
        """How often its process was started again: never, where it is this one."""
        return 0

    @property
    def last_s(self) -> float:
        """Seconds from the start of the run to the last step."""
        return (self.last_utime - self.start_utime) / 1e6

    @abstractmethod
    def reset(self, run_seed: int, seed: int) -> None:
        """Reset the state of the stage from its ``seed``; raises StageError if the stage raises."""

    @abstractmethod
    def step(self, utime: int, inputs: dict[str, Any], age_s: float = 0.0) -> str | None:
        """Step once with ``inputs`` by port and publish; return the outcome if a source ended the run.

        ``inputs`` becomes the arguments of the step.

        Raises
        ------
        StageError
            The step raised, or returned something invalid.
        """

    @abstractmethod
    def due_us(self, firing: int) -> int:
        """Return when a firing of a source is due, microseconds after the first one.

        Raises
        ------
        StageError
            The stage raised, or returned a time that is not after that of the firing before.
        """

    def arrived_s(self) -> float | None:
        """Return when what the next step of a `LiveSource` publishes was taken, monotonic seconds, None for nothing.

        Raises
        ------
        StageError
            The stage raised.
        """
        raise NotImplementedError

    def notices(self) -> list[str]:
        """Return what a `LiveSource` has to tell since the last call; raises StageError if the stage raises."""
        raise NotImplementedError

    @abstractmethod
    def patience_s(self) -> float:
        """Return how long a live firing waits for `Since` inputs; raises StageError if the stage raises."""

    @abstractmethod
    def metrics(self) -> dict[str, float] | None:
        """Return the metrics of the stage after a run, None if it reports none.

        Raises
        ------
        StageError
            Its summary fails, or holds what the stage does not declare.
        """

    @abstractmethod
    def close(self, at_s: float) -> None:
        """Close the stage; raises StageError if it raises."""


class LocalUnit(Unit[I]):
    """A stage of this process.

    ``wrap_step``: returns what is called in place of the step of a stage, by name.
    """

    def __init__(
        self,
        node: Node,
        stage: Stage,
        inbox: I,
        publish: Publish,
        calls: StageCalls,
        wrap_step: Callable[[str, Callable[..., Any]], Callable[..., Any]],
        start_utime: int,
    ) -> None:
        super().__init__(node, inbox, start_utime)
        self._due_us: dict[int, int] = {}
        """When the last firing asked for is due, by its number."""
        self._publish, self._calls, self._wrap_step = publish, calls, wrap_step
        self._take_stage(node, stage)

    def change(self, node: Node, stage: Stage, inbox: I, at_s: float) -> StageError | None:
        """Step another stage from now on, which is reset; return what the one before raised when it was closed."""
        failed = None
        try:
            self.close(at_s)
        except StageError as error:
            failed = error
        inbox.adopt(self.inbox)
        self.node, self.inbox = node, inbox
        self._take_stage(node, stage)
        return failed

    def _take_stage(self, node: Node, stage: Stage) -> None:
        self._stage = stage
        self._step = self._wrap_step(node.name, getattr(stage, "step"))  # noqa: B009 - a Stage has no step of its own
        ports = ports_of(node.stage_class)
        self._stamps, self._ages = ports.stamps, ports.ages
        self._result = ports.result
        self._open = [i.port.name for i in node.inputs if i.port.is_plain and i.channel is None]
        self._outputs = [(port, node.outputs[port.name]) for port in ports.outputs]

    def reset(self, run_seed: int, seed: int) -> None:
        """Reset the state of the stage from its ``seed``; raises StageError if the stage raises."""
        with self._calling("reset", 0.0, _said):
            tell_run_seed(self._stage, run_seed)
            self._stage.reset(seed)

    def step(self, utime: int, inputs: dict[str, Any], age_s: float = 0.0) -> str | None:
        """Step once with ``inputs`` by port and publish; return the outcome if a source ended the run.

        ``inputs`` becomes the arguments of the step.

        Raises
        ------
        StageError
            The step raised, or returned something invalid.
        """
        self.last_utime = utime
        for name in self._open:
            inputs.setdefault(name)
        for name in self._stamps:
            inputs[name] = utime
        for name in self._ages:
            inputs[name] = age_s
        outcome = None
        self._calls.begin(self.node.name, "step", utime, inputs)
        begin = perf_counter()
        try:
            result = self._step(**inputs)
        except CtrlC:
            raise
        except Finished as finished:
            outcome, result = finished.outcome, finished.outputs
        except BaseException as error:
            raise self._failure(utime, failure_line(error), error) from error
        finally:
            end = perf_counter()
            self._calls.end()
        self.durations.add(end - begin)
        if result is not None:
            self._publish_all(utime, result)
        return outcome

    @contextmanager
    def _calling(self, method: str, at_s: float, said: Callable[[BaseException], str] | None = None) -> Iterator[None]:
        """Call another method of the stage than ``step``; whatever it raises becomes a StageError.

        ``at_s``: seconds since the start. ``said``: returns what the error says of an exception; by default the
        method's name and the exception in one line.
        """
        self._calls.begin(self.node.name, method, self.last_utime, {})
        try:
            yield
        except CtrlC:
            raise
        except BaseException as error:
            what = f"{method}: {one_line(error)}" if said is None else said(error)
            raise StageError(self.node.name, self.node.use, at_s, what, self._raised(error)) from error
        finally:
            self._calls.end()

    def due_us(self, firing: int) -> int:
        """Return when a firing of a source is due, microseconds after the first one.

        Raises
        ------
        StageError
            The stage raised, or returned a time that is not after that of the firing before.
        """
        source = self._stage
        assert isinstance(source, Source)
        with self._calling("due_us", self.last_s):
            due_us = source.due_us(firing)
            if not due_us > self._due_us.get(firing - 1, min(firing, 1) - 1):
                raise ValueError(f"firing {firing} is due at {shown_value(due_us)} us, not after the one before")
            self._due_us = {firing: due_us}
            return due_us

    def arrived_s(self) -> float | None:
        """Return when what the next step of a `LiveSource` publishes was taken, monotonic seconds, None for nothing.

        Raises
        ------
        StageError
            The stage raised.
        """
        source = self._stage
        assert isinstance(source, LiveSource)
        with self._calling("arrived_s", self.last_s):
            return source.arrived_s()

    def notices(self) -> list[str]:
        """Return what a `LiveSource` has to tell since the last call; raises StageError if the stage raises."""
        source = self._stage
        assert isinstance(source, LiveSource)
        with self._calling("notices", self.last_s):
            return list(source.notices())

    def patience_s(self) -> float:
        """Return how long a live firing waits for `Since` inputs; raises StageError if the stage raises."""
        with self._calling("patience_s", self.last_s):
            return float(self._stage.patience_s())

    def metrics(self) -> dict[str, float] | None:
        """Return the metrics of the stage after a run, None if it reports none; raises StageError if that fails."""
        if type(self._stage).summary is Stage.summary:
            return None
        with self._calling("summary", self.last_s):
            return reported_metrics(self._stage)

    def close(self, at_s: float) -> None:
        """Close the stage; raises StageError if it raises."""
        with self._calling("close", at_s, lambda error: f"close: {_said(error)}"):
            self._stage.close()

    def _publish_all(self, utime: int, result: Any) -> None:
        """Publish the outputs, which may be objects of the plugin's own classes: what they raise is the stage's."""
        where = "outputs"
        try:
            for (port, channel), value in zip(self._outputs, self._values(utime, result)):  # noqa: B905, a NamedTuple has all, and strict costs time
                where = f"output '{port.name}'"
                stamp, message = (value.utime, value.message) if isinstance(value, Stamped) else (utime, value)
                if message is not None:
                    self._check(utime, port, message)
                    self._publish(channel, stamp, message)
        except (GraphnavError, OSError, CtrlC):  # a failure, or of the log and the network
            raise
        except BaseException as error:
            raise self._failure(utime, f"{where}: {failure_line(error)}", error) from error

    def _check(self, utime: int, port: Port, message: Any) -> None:
        if not isinstance(message, port.message):
            raise self._failure(utime, f"output '{port.name}' is {type(message).__name__}, not {port.message.__name__}")
        if wrong := not_finite(message):
            raise self._failure(utime, f"output '{port.name}' holds a NaN or an infinity in '{wrong}'")

    def _values(self, utime: int, result: Any) -> Any:
        """Return what a step returned as one value for each output."""
        if self._result is None:
            if not self._outputs:
                raise self._failure(utime, f"step returned {type(result).__name__}, but declares no output")
            return (result,)
        if not isinstance(result, self._result):
            raise self._failure(utime, f"step returned {type(result).__name__}, not {self._result.__name__}")
        return result

    def _failure(self, utime: int, what: str, error: BaseException | None = None) -> StageError:
        raised = self._raised(error) if error is not None else ""
        return StageError(self.node.name, self.node.use, (utime - self.start_utime) / 1e6, what, raised)

    def _raised(self, error: BaseException) -> str:
        return raised_line(error, (cls.__module__ for cls in self.node.stage_class.__mro__))


def _said(error: BaseException) -> str:
    """Return an exception in one line: the message, with the type where it would not tell enough."""
    return (message_line(error) if isinstance(error, Exception) else "") or one_line(error)
