"""Inputs and results of steps, as frames hold them."""

from __future__ import annotations

import json
import math
import traceback
import zlib
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from graphnav import GraphnavError, Latest, Message, Since
from graphnav.core.codec import decode
from graphnav.core.errors import StageError
from graphnav.core.graph import Input, Node
from graphnav.core.interrupts import CtrlC
from graphnav.core.runner import Done, Encoded
from graphnav.core.stage import Port
from graphnav.processes.frames import Frame


class InputsSent:
    """Packs the inputs of the steps of one stage; a message that the step before was given, too, is not sent again."""

    def __init__(self, node: Node) -> None:
        self._ports = _connected(node)
        self._given: dict[str, Encoded] = {}

    def packed(self, inputs: Mapping[str, Any]) -> tuple[list[Any], list[Encoded]]:
        """Return the inputs for the head of a frame, one for each wired port, and the messages of the frame."""
        head: list[Any] = []
        messages: list[Encoded] = []
        for i in self._ports:
            given = inputs[i.port.name]
            if i.port.latest:
                head.append(self._sampled(i.port.name, given, messages))
            elif i.port.since:
                head.append([utime for utime, _ in given.messages])
                messages += [message for _, message in given.messages]
            else:
                head.append(self._is_new(i.port.name, given, messages))
        return head, messages

    def _sampled(self, port: str, given: Latest[Any], messages: list[Encoded]) -> list[Any] | None:
        """Return a sampled message's age, whether it is new to the stage, and the fault of its input."""
        if given.value is None and not given.fault:
            return None
        return [given.age_s, self._is_new(port, given.value, messages), given.fault]

    def _is_new(self, port: str, given: Encoded | None, messages: list[Encoded]) -> bool | None:
        """Return whether a message is new to the stage, and append it then; None where there is none."""
        if given is None:
            return None
        is_new = self._given.get(port) is not given
        if is_new:
            self._given[port] = given
            messages.append(given)
        return is_new


class InputsReceived:
    """Unpacks what `InputsSent` packed."""

    def __init__(self, node: Node) -> None:
        self._ports = _connected(node)
        self._open = {
            i.port.name: Latest[Any](is_connected=False) if i.port.latest else Since[Any]()
            for i in node.inputs
            if i.channel is None and not i.port.is_plain
        }
        self._given: dict[str, Message] = {}

    def unpacked(self, head: Sequence[Any], messages: Sequence[bytes]) -> dict[str, Any]:
        """Return the inputs of a step by port, as an inbox would."""
        left = iter(messages)
        inputs: dict[str, Any] = dict(self._open)
        for i, said in zip(self._ports, head, strict=True):
            port, kind = i.port, i.port.message
            if port.latest:
                age_s, is_new, fault = said or (math.inf, None, "")
                inputs[port.name] = Latest(self._message(port, is_new, left), age_s, fault)
            elif port.since:
                inputs[port.name] = Since(tuple((utime, decode(kind, next(left))[2]) for utime in said))
            else:
                inputs[port.name] = self._message(port, said, left)
        return inputs

    def _message(self, port: Port, is_new: bool | None, left: Iterator[bytes]) -> Message | None:  # noqa: FBT001 - as it was sent
        if is_new:
            self._given[port.name] = decode(port.message, next(left))[2]
        return None if is_new is None else self._given[port.name]


def _connected(node: Node) -> list[Input]:
    return [i for i in node.inputs if i.channel is not None]


class TracebackOfAnotherProcess(Exception):  # noqa: N818 - it is where an error was raised
    """The traceback of an error, as its process printed it."""

    def __str__(self) -> str:
        return f"\n\n{super().__str__()}"


def packed_error(error: BaseException | None) -> Any:
    """Return an error as JSON holds it, None for none."""
    if error is None:
        return None
    raised = "" if error.__cause__ is None else "".join(traceback.format_exception(error.__cause__))
    if isinstance(error, StageError):
        return {"stage": [error.stage, error.use, error.at_s, error.what, error.raised_at], "raised": raised}
    return {"said": str(error), "raised": raised, "is_interrupt": isinstance(error, CtrlC)}


def unpacked_error(said: Any) -> GraphnavError | None:
    """Return the error that another process met; raises CtrlC where the user interrupted a step."""
    if said is None:
        return None
    if said.get("is_interrupt"):
        raise CtrlC
    error = StageError(*said["stage"]) if "stage" in said else GraphnavError(said["said"])
    if said["raised"]:
        error.__cause__ = TracebackOfAnotherProcess(said["raised"])
    return error


def unpacked_done(node: Node, frame: Frame) -> Done:
    """Return what became of a step; raises CtrlC where the user interrupted it."""
    head = frame.head
    ports = list(node.outputs)
    outputs = ((ports[k], utime, data) for (k, utime), data in zip(head["outputs"], frame.messages, strict=True))
    due = head["due"]
    return Done(
        tuple(outputs),
        head["outcome"],
        unpacked_error(head["error"]),
        head["took_s"],
        unpacked_error(due) if isinstance(due, dict) else due,
        head["skipped"],
    )


def digest_of(frame: Frame) -> int:
    """Return a number that is the same for the same outputs, outcome and error of a step."""
    told = [frame.head[key] for key in ("outputs", "outcome", "due")]
    digest = zlib.crc32(json.dumps(told).encode())
    for data in frame.messages:
        digest = zlib.crc32(data, digest)
    return digest
