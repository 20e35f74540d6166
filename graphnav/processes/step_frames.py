"""Inputs and results of steps, as frames hold them."""

from __future__ import annotations

import json
import traceback
import zlib
from collections.abc import Mapping, Sequence
from typing import Any

from graphnav import GraphnavError, Latest, Message, Since
from graphnav.core.codec import decode
from graphnav.core.errors import StageError
from graphnav.core.graph import Input, Node
from graphnav.core.interrupts import CtrlC
from graphnav.core.runner import Done, Encoded
from graphnav.processes.frames import Frame


class InputsSent:
    """Packs the inputs of the steps of one stage; a sampled message that it was given before is not sent again."""

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
                head.append(None)
                messages.append(given)
        return head, messages

    def _sampled(self, port: str, given: Latest[Any], messages: list[Encoded]) -> list[Any] | None:
        """Return the age of a sampled message and whether it is new to the stage."""
        if given.value is None:
            return None
        is_new = self._given.get(port) is not given.value
        if is_new:
            self._given[port] = given.value
            messages.append(given.value)
        return [given.age_s, is_new]


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
                if said is not None and said[1]:
                    self._given[port.name] = decode(kind, next(left))[2]
                inputs[port.name] = Latest() if said is None else Latest(self._given[port.name], said[0])
            elif port.since:
                inputs[port.name] = Since(tuple((utime, decode(kind, next(left))[2]) for utime in said))
            else:
                inputs[port.name] = decode(kind, next(left))[2]
        return inputs


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
    )


def digest_of(frame: Frame) -> int:
    """Return a number that is the same for the same outputs, outcome and error of a step."""
    told = [frame.head[key] for key in ("outputs", "outcome", "due")]
    digest = zlib.crc32(json.dumps(told).encode())
    for data in frame.messages:
        digest = zlib.crc32(data, digest)
    return digest
