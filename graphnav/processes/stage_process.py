"""A process of stages, as the run sees it: what it is asked, one thing at a time, and how it is given all again."""

from __future__ import annotations

import socket
from collections import deque
from collections.abc import Iterator, Sequence
from contextlib import suppress
from typing import Any

from graphnav import GraphnavError
from graphnav.core.graph import Node, Part
from graphnav.core.runner import Encoded
from graphnav.processes.descriptors import is_readable
from graphnav.processes.frames import Frame, Kind, Link
from graphnav.processes.host_clock import ClockState
from graphnav.processes.journal import Journal
from graphnav.processes.step_frames import digest_of, unpacked_error


class Request:
    """A frame that the process is sent, and its answer.

    ``digest``: of the answer that is expected, where the process is given a step again.
    """

    __slots__ = ("answer", "digest", "head", "is_lost", "kind", "messages")

    def __init__(self, kind: Kind, head: Any, messages: Sequence[Encoded] = (), digest: int | None = None) -> None:
        self.kind, self.head, self.messages, self.digest = kind, head, messages, digest
        self.answer: Frame | None = None
        self.is_lost = False
        """Whether the process ended before it answered, and no other one is asked."""

    @property
    def frame(self) -> Frame:
        """The frame that is sent."""
        return Frame(self.kind, self.head, tuple(message.data for message in self.messages))


class StageProcess:
    """The stages ``nodes`` in a process of their own, which is one process after another where it is started again.

    It answers one request before it is sent the next one, so that neither side ever waits for the other to read.
    ``setup``: the head of the first frame of each. ``journal``: keeps its steps, None where it is never started again.
    ``is_live``: a new one is only reset; what the one before was asked is lost.
    """

    def __init__(
        self, part: Part, nodes: Sequence[Node], setup: Any, journal: Journal | None, *, is_live: bool
    ) -> None:
        self.part, self.nodes = part, nodes
        self.restarts = 0
        """How often it was started again."""
        self.failure = ""
        """Why it is down for good, in a sentence that begins with "its process"; empty while it is not."""
        self.hint = ""
        self.link: Link | None = None
        self.clock: ClockState | None = None
        """Of the host that it lives on, None while that is not known, or where it lives on none."""
        self.is_interrupted = False
        """Whether a step of it was broken off, after which its stages are only asked for metrics and closed."""
        self.setup, self._journal, self._is_live = setup, journal, is_live
        self.is_made = False
        """Whether there is a process that has made its stages."""
        self._has_begun = False
        """Whether it has all that the process before it had."""
        self._reset: Request | None = None
        self._first: Iterator[Request] = iter(())
        self._pending: deque[Request] = deque()
        self._current: Request | None = None
        self._preparing: dict[int, Request] = {}
        """The stages that are made there beside those that step, by their numbers."""
        self._n_prepared = 0

    @property
    def is_busy(self) -> bool:
        """Whether it has something to answer."""
        return self._current is not None or bool(self._pending)

    @property
    def is_free(self) -> bool:
        """Whether it has been reset and has nothing to answer."""
        return self.is_there and not self.is_busy

    @property
    def is_there(self) -> bool:
        """Whether it runs and has all that the process before it had."""
        return self.link is not None and self._has_begun

    @property
    def is_ready(self) -> bool:
        """Whether it is there, and its stages have been reset."""
        return self.is_there and self._reset is not None and self._reset.answer is not None

    @property
    def is_down(self) -> bool:
        """Whether it is gone and is not started again."""
        return bool(self.failure)

    def post(self, kind: Kind, head: Any, messages: Sequence[Encoded] = ()) -> Request:
        """Ask for something; the answer comes with `read`, unless the process is down."""
        request = Request(kind, head, messages)
        if not self.is_down:
            self._pending.append(request)
            self._send_next()
        return request

    def prepare(self, head: dict[str, Any]) -> Request:
        """Ask for another stage, made while the stages go on; it is lost if the process ends before it takes over."""
        self._n_prepared += 1
        return self.post(Kind.PREPARE, {**head, "number": self._n_prepared})

    def change(self, prepared: Request, head: dict[str, Any]) -> Request:
        """Let a stage that is prepared take over, whatever becomes of the process."""
        self._preparing.pop(prepared.head["number"], None)
        return self.post(Kind.CHANGE, head)

    def drop(self, prepared: Request) -> None:
        """Forget a stage that is prepared."""
        if self._preparing.pop(prepared.head["number"], None) is not None:
            self.post(Kind.DROP, prepared.head["place"])

    def ordered_reset(self, order: tuple[int, int]) -> Request:
        """Return the request that resets all stages by the seed of the run and its clock, which is made once."""
        if self._reset is None or self._reset.head != order:
            self._reset = self.post(Kind.RESET, order)
        return self._reset

    def connected(self, link: socket.socket) -> None:
        """Take the connection of a process that has just started, and give it all that the one before had."""
        self.link = Link(link)
        self._first, self._has_begun = self._again(), False
        self._send_next()

    def read(self) -> None:
        """Take the answer if all of it has arrived, and send what is next.

        Raises
        ------
        EOFError, OSError, ValueError
            The process is gone, or sends something else.
        GraphnavError
            It cannot be brought to where the run is: what it answers is not what it answered before.
        """
        assert self.link is not None, "it is connected"
        answer = self.link.receive()
        if answer is None:
            return
        if answer.kind == Kind.CLOCK:
            self.clock = ClockState(*answer.head)
            return
        if answer.kind == Kind.PREPARED:
            if (prepared := self._preparing.get(answer.head["number"])) is not None:
                prepared.answer = answer
            return
        request, self._current = self._current, None
        if request is None or answer.kind != Kind.ANSWER:
            raise ValueError("it answers what it was not asked")
        if request.kind == Kind.SETUP:
            if answer.head is not None:
                raise GraphnavError(answer.head)
            self.is_made = True
        elif request.digest is not None:
            self._compare(request, answer)
        else:
            self._take(request, answer)
        self._send_next()

    def has_answered(self) -> bool:
        """Whether an answer, or a part of it, is there to be read."""
        return self.link is not None and is_readable(self.link.fileno())

    def disconnected(self) -> None:
        """Note that the process has ended: what it has not answered is asked again of the next one, or lost."""
        if self.link is not None:
            self.link.close()
            self.link = None
        self.is_made, self.clock = False, None
        if self._current is not None and self._current.kind != Kind.SETUP and self._current.digest is None:
            self._pending.appendleft(self._current)
        self._current = None
        for request in self._preparing.values():
            request.is_lost = True
        self._preparing.clear()
        if self._is_live:
            for request in self._pending:
                request.is_lost = request.kind not in {Kind.RESET, Kind.PREPARE}
            self._pending = deque(request for request in self._pending if not request.is_lost)

    def give_up(self, why: str, hint: str = "") -> None:
        """Note that it is not started again."""
        self.failure, self.hint = why, hint
        self._pending.clear()
        self._current = None

    def drop_pending(self) -> None:
        """Forget what it was not sent yet."""
        self._pending.clear()

    def _take(self, request: Request, answer: Frame) -> None:
        if request.kind == Kind.CHANGE:
            self._raise_if_unchanged(request, answer)
        request.answer = answer
        if self._journal is None:
            return
        if request.kind == Kind.FIRE:
            self._journal.keep(self.part.name, Kind.FIRE, request.head, request.messages, digest_of(answer))
        elif request.kind == Kind.CHANGE:
            self._journal.keep(self.part.name, Kind.CHANGE, request.head, (), 0)

    def _compare(self, request: Request, answer: Frame) -> None:
        if request.kind == Kind.RESET:
            if (error := unpacked_error(answer.head["error"])) is not None:
                raise GraphnavError("its stages can be reset only once") from error
        elif request.kind == Kind.CHANGE:
            self._raise_if_unchanged(request, answer)
        elif digest_of(answer) != request.digest:
            stage = self.nodes[request.head[0]].name
            raise GraphnavError(
                f"stage '{stage}' did not publish the same when it was given the same again: what it does depends on "
                "more than its parameters, seed and inputs"
            )

    def _raise_if_unchanged(self, request: Request, answer: Frame) -> None:
        if (error := unpacked_error(answer.head["error"])) is not None:
            name = self.nodes[request.head["place"]].name
            raise GraphnavError(f"stage '{name}' cannot be changed again as it was: {error}") from error

    def _again(self) -> Iterator[Request]:
        """Yield what a new process is sent first: the set-up, and where it is not the first one all steps again."""
        yield Request(Kind.SETUP, self.setup)
        if self._reset is None or self._reset.answer is None:
            return
        yield Request(Kind.RESET, self._reset.head, digest=0)
        if self._journal is not None:
            for given in self._journal.steps(self.part.name):
                yield Request(Kind(given.kind), given.head, [Encoded(data) for data in given.messages], given.digest)

    def _send_next(self) -> None:
        while self.link is not None and self._current is None:
            request = next(self._first, None)
            if request is None:
                self._has_begun = self._reset is not None
                request = self._pending.popleft() if self._pending else None
            if request is None:
                return
            if request.kind == Kind.PREPARE:
                self._preparing[request.head["number"]] = request
            else:
                self._current = request
            with suppress(OSError):  # it has ended, which is noticed when it is waited for
                self.link.send(request.frame)
