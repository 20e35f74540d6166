"""One stage at work: its inbox, its firing, what it costs."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

from graphnav.errors import StageError
from graphnav.graph import Channel, Node
from graphnav.messages import Message
from graphnav.runner.durations import Durations
from graphnav.stage import Finished, Latest, Stage, ports_of

Publish = Callable[[Channel, int, Message], None]


class Unit:
    """Holds what arrived for a stage, fires it when its plain inputs are complete, publishes what it returns."""

    def __init__(self, node: Node, stage: Stage, publish: Publish) -> None:
        self.node, self.stage = node, stage
        self.durations = Durations()
        self.dropped = 0
        self.last_utime = 0
        self._publish = publish
        self._step: Callable[..., Any] = getattr(stage, "step")  # noqa: B009 - a Stage has no step of its own
        ports = ports_of(node.stage_class)
        self._stamps = ports.stamps
        self._result = ports.result
        self._plain = [i.port.name for i in node.inputs if not i.port.latest]
        self._sampled = [i.port.name for i in node.inputs if i.port.latest]
        self._inbox: dict[str, Message] = {}
        self._latest: dict[str, tuple[int, Message]] = {}
        self._outputs = [(port, node.outputs[port.name]) for port in ports.outputs]

    def deliver(self, port: str, utime: int, message: Message) -> None:
        """Put a message of the tick's stamp into the inbox."""
        if port in self._sampled:
            self._latest[port] = (utime, message)
        else:
            self._inbox[port] = message

    @property
    def is_complete(self) -> bool:
        """Whether every plain input holds a message of this tick."""
        return len(self._inbox) == len(self._plain)

    def discard(self) -> None:
        """Drop what stayed incomplete, and count it."""
        if self._inbox:
            self._inbox.clear()
            self.dropped += 1

    def fire(self, utime: int) -> str | None:
        """Step once and publish; return the outcome where a source ended the run.

        Raises
        ------
        StageError
            The step raised, or returned what it may not.
        """
        self.last_utime = utime
        arguments: dict[str, Any] = dict(self._inbox)
        self._inbox.clear()
        for port in self._sampled:
            arguments[port] = self._sample(port, utime)
        for name in self._stamps:
            arguments[name] = utime
        outcome = None
        begin = time.perf_counter()
        try:
            result = self._step(**arguments)
        except Finished as finished:
            outcome, result = finished.outcome, finished.outputs
        except (Exception, SystemExit) as error:
            raise self._failure(utime, _said(error)) from error
        self.durations.add(time.perf_counter() - begin)
        if result is not None:
            self._publish_all(utime, result)
        return outcome

    def _sample(self, port: str, utime: int) -> Latest[Any]:
        if port not in self._latest:
            return Latest()
        sent, message = self._latest[port]
        return Latest(message, (utime - sent) / 1e6)

    def _publish_all(self, utime: int, result: Any) -> None:
        if self._result is None:
            values: Any = (result,)
            if not self._outputs:
                raise self._failure(utime, f"step returned {type(result).__name__}, but declares no output")
        elif isinstance(result, self._result):
            values = result
        else:
            raise self._failure(utime, f"step returned {type(result).__name__}, not {self._result.__name__}")
        for (port, channel), value in zip(self._outputs, values, strict=True):
            if value is None:
                continue
            if not isinstance(value, port.message):
                raise self._failure(
                    utime, f"output '{port.name}' is {type(value).__name__}, not {port.message.__name__}"
                )
            try:
                wrong = value.not_finite()
            except (TypeError, ValueError, AttributeError) as error:
                raise self._failure(utime, f"output '{port.name}': {_said(error)}") from error
            if wrong:
                raise self._failure(utime, f"output '{port.name}' holds a NaN or an infinity in '{wrong}'")
            try:
                self._publish(channel, utime, value)
            except (TypeError, ValueError, AttributeError) as error:
                raise self._failure(utime, f"output '{port.name}': {_said(error)}") from error

    def _failure(self, utime: int, what: str) -> StageError:
        return StageError(self.node.name, self.node.use, utime / 1e6, what)


def _said(error: BaseException) -> str:
    """Return an exception in one line."""
    text = " ".join(str(error).split())
    if isinstance(error, ValueError | RuntimeError) and text:
        return text
    return f"{type(error).__name__}: {text}" if text else type(error).__name__
