"""Connections between hosts: TCP, framed as between processes, with a key that both ends prove to have.

A `HostListener` takes connections, a `HostCaller` makes one and makes it again after a cut; both hand out a `HostLink`
once it is proven. Nothing here waits: the owner polls what ``pollables`` names, and calls ``step`` and ``receive``.

**Authentication.** Both ends have a key (`host_key`). Each sends a nonce and gets back the HMAC (SHA-256) of both
nonces, of the service and of the role of who answers, first the calling end. The key is never sent, and an answer is of
no use for another connection. What follows is neither encrypted nor signed: those who can change packets on their way
can read and change it. Over a network where that matters, let ``ssh -L`` carry it.

**Other programs.** Before its proof an end may send frames of at most 512 bytes and has 5 s; at most 16 connections
wait for a proof, and the oldest is closed for a new one. All that sends anything else is closed and counted by reason.

**Silence.** A proven end sends a sign of life every second. Where nothing comes for 5 s, the link is lost.

**Clocks.** A sign of life asks for the time of day, unless an answer is still to come: it has the time at which it was
sent. The answer repeats that, and has the time of day there and how long the question was held (`HostClock`).
"""

from __future__ import annotations

import hashlib
import hmac
import math
import secrets
import select
import socket
import threading
import time
from collections import Counter
from collections.abc import Callable, Collection, Mapping
from contextlib import suppress
from enum import IntEnum, StrEnum
from types import MappingProxyType
from typing import Any

from graphnav import GraphnavError
from graphnav.processes.frames import Frame, Link
from graphnav.processes.host_clock import ClockState, HostClock, boot_ns, read_clocks

VERSION = 2
"""Of this protocol."""
MAX_FRAME_BYTES = 32 << 20
"""Twice the largest message that liblcm puts together."""
_MAX_UNPROVEN_BYTES = 512
_MAX_UNPROVEN = 16
_PROOF_S = 5.0
_SILENT_S = 5.0
_ALIVE_S = 1.0
_CONNECT_S = 5.0
_PAUSE_S, _MAX_PAUSE_S = 0.2, 2.0
_UNSENT_BYTES = 1 << 17
"""Bytes that the kernel holds while the network has no room for them: more would only be old when they arrive."""
_NONCE_BYTES = 32
_END_NS = 1 << 62
"""Times are below, nanoseconds."""


class Refusal(StrEnum):
    """Why a connection was closed; the reasons for which an end closes it are told to the other end."""

    KEY = "another key"
    VERSION = "another version"
    SERVICE = "another service"
    FULL = "too many connections"
    FOREIGN = "something else than frames"
    SILENT = "no proof in time"
    CROWDED = "closed for newer ones without proof"
    GONE = "closed without proof"


_FINAL = {Refusal.KEY, Refusal.VERSION, Refusal.SERVICE, Refusal.FOREIGN}
"""Reasons that time does not change."""


class LinkError(GraphnavError):
    """A link is lost, or was never made; ``reason`` is `Refusal.GONE` where the other end or the network ended it."""

    def __init__(self, what: str, reason: Refusal) -> None:
        self.reason = reason
        super().__init__(what)


class _Kind(IntEnum):
    """Frames of this module; smaller kinds are its users'."""

    HELLO = 240
    PROOF = 241
    REFUSED = 242
    ALIVE = 243
    """A sign of life: the question for the time of day, or null."""
    CLOCK = 244
    """The answer: the question, how long it was held, and the time of day."""


class HostLink:
    """One end of a connection, of the one that called or of the one that listened.

    It owns the socket. ``peer``: address and port of the other end. ``is_full``: whether one that listens refuses who
    has proven the key, because there are too many.
    """

    def __init__(
        self,
        connection: socket.socket,
        key: bytes,
        service: str,
        *,
        calls: bool,
        is_full: Callable[[], bool] = lambda: False,
    ) -> None:
        self.peer = _shown(connection.getpeername())
        self.is_proven = False
        """Whether the other end has proven that it has the key, and this end to the other one."""
        self.begin_s = time.monotonic()
        self.after_s: float | None = None
        """How long there was no connection after a cut; None for the first one, and where this end listens."""
        self._key, self._service, self._calls, self._is_full = key, service, calls, is_full
        self._nonces = {calls: secrets.token_hex(_NONCE_BYTES)}
        """Of both ends, by whether it is the one that called."""
        self.clock = HostClock()
        """The clock of the other end."""
        self.wall_ns: Callable[[], int] = time.time_ns
        """Reads this machine's time of day."""
        self._asked_ns: int | None = None
        """The question that is not answered yet, as all such times by the time since this machine's boot."""
        self._question: tuple[int, int] | None = None
        """The newest one of the other end that is not answered yet, and when it came."""
        self._heard_s = self.begin_s
        self._alive_s = -math.inf
        self._n_heard = 0
        connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NOTSENT_LOWAT, _UNSENT_BYTES)
        self._link = Link(connection, _MAX_UNPROVEN_BYTES)
        if not calls:
            self.send(Frame(_Kind.HELLO, {"graphnav": VERSION, "service": service, "nonce": self._nonces[calls]}))

    def fileno(self) -> int:
        """Return the descriptor, for a poll."""
        return self._link.fileno()

    @property
    def is_sending(self) -> bool:
        """Whether a part of a frame is not sent yet; further ones should wait until it is."""
        return self._link.is_sending

    def close(self) -> None:
        """Close the connection."""
        self._link.close()

    def send(self, frame: Frame) -> None:
        """Send a frame as far as the network takes it; raises LinkError if the other end is gone."""
        self._tell_time()
        self._send(frame)

    def send_more(self) -> None:
        """Send what is left, as far as the network takes it; raises LinkError if the other end is gone."""
        try:
            self._link.send_more()
        except OSError as error:
            raise self._gone(error) from error

    def receive(self) -> Frame | None:
        """Return the next frame of the other end's user, None while there is none.

        Raises
        ------
        LinkError
            The other end is gone, or sent what it may not.
        """
        while True:
            try:
                frame = self._link.receive()
            except EOFError as error:
                raise LinkError(f"{self.peer} closed the connection", Refusal.GONE) from error
            except OSError as error:
                raise self._gone(error) from error
            except ValueError as error:
                raise self._foreign() from error
            if frame is None or (self.is_proven and frame.kind < _Kind.HELLO):
                return frame
            was_proven = self.is_proven
            self._take(frame)
            if self.is_proven and not was_proven:
                return None  # its owner receives what follows

    def tick(self, now_s: float) -> None:
        """Tell the other end now and then that this one lives; raises LinkError if that has been silent."""
        if not self.is_proven:
            if now_s - self.begin_s > _PROOF_S:
                raise LinkError(f"{self.peer} proved nothing within {_PROOF_S:g} s", Refusal.SILENT)
            return
        if self._link.n_received != self._n_heard:
            self._n_heard, self._heard_s = self._link.n_received, now_s
        if now_s - self._heard_s > _SILENT_S:
            raise LinkError(f"nothing has come from {self.peer} for {_SILENT_S:g} s", Refusal.GONE)
        self._tell_time()

    def clock_state(self) -> ClockState | None:
        """Return how far the clock of the other end is ahead of this machine's, None while that is not known."""
        return self.clock.state(read_clocks(self.wall_ns))

    def go_on(self, ready: Collection[int], now_s: float) -> None:
        """Go on with proving, if there is something to do; raises LinkError as `receive` and `tick` do."""
        if self.fileno() in ready:
            self.send_more()
            self.receive()
        self.tick(now_s)

    def refuse(self, reason: Refusal) -> None:
        """Tell the other end why this one closes the connection, and close it."""
        with suppress(LinkError):
            self.send(Frame(_Kind.REFUSED, {"why": reason.name}))
        self.close()

    def _take(self, frame: Frame) -> None:
        """Handle a frame of this module."""
        head = frame.head if isinstance(frame.head, dict) else {}
        if frame.kind == _Kind.REFUSED:
            raise self._refused(head)
        if self.is_proven:
            self._take_time(frame)
        elif frame.kind == _Kind.HELLO and self._calls and False not in self._nonces:
            self._answer_hello(head)
        elif frame.kind == _Kind.PROOF:
            self._check(head)
        else:
            raise self._foreign()

    def _send(self, frame: Frame) -> None:
        try:
            self._link.send(frame)
        except OSError as error:
            raise self._gone(error) from error

    def _tell_time(self) -> None:
        """Answer the question of the other end, and ask it once a second; neither while a frame is not sent yet."""
        if not self.is_proven or self.is_sending:
            return
        if self._question is not None:
            (asked_ns, came_ns), self._question = self._question, None
            self._send(Frame(_Kind.CLOCK, (asked_ns, boot_ns() - came_ns, self.wall_ns())))
        now_s = time.monotonic()
        if now_s - self._alive_s >= _ALIVE_S:
            self._alive_s = now_s
            is_open = self._asked_ns is not None
            if not is_open:
                self._asked_ns = boot_ns()
            self._send(Frame(_Kind.ALIVE, None if is_open else self._asked_ns))

    def _take_time(self, frame: Frame) -> None:
        """Take a sign of life, or an answer to one."""
        now_ns = boot_ns()
        match frame:
            case Frame(_Kind.ALIVE, None):
                pass
            case Frame(_Kind.ALIVE, asked_ns) if _is_time(asked_ns):
                self._question = asked_ns, now_ns
                self._tell_time()
            case Frame(_Kind.CLOCK, [asked_ns, held_ns, wall_ns]) if (
                all(map(_is_time, frame.head)) and asked_ns == self._asked_ns
            ):
                self._asked_ns = None
                self.clock.add(asked_ns, now_ns, held_ns, wall_ns)
            case _:
                raise self._foreign()

    def _answer_hello(self, head: Mapping[str, Any]) -> None:
        if head.get("graphnav") != VERSION:
            raise LinkError(f"{self.peer} has another version of this protocol than {VERSION}", Refusal.VERSION)
        if head.get("service") != self._service:
            raise LinkError(f"{self.peer} serves another thing than a {self._service}", Refusal.SERVICE)
        self._take_nonce(head, calls=False)
        self.send(Frame(_Kind.PROOF, {"nonce": self._nonces[True], "proof": self._proof(calls=True)}))

    def _check(self, head: Mapping[str, Any]) -> None:
        """Check the proof of the other end; raise LinkError if it has another key."""
        if not self._calls:
            self._take_nonce(head, calls=True)
        elif False not in self._nonces:
            raise self._foreign()
        proof = head.get("proof")
        if not isinstance(proof, str):
            raise self._foreign()
        expected = self._proof(calls=not self._calls)
        if not hmac.compare_digest(proof.encode("utf-8", "replace"), expected.encode()):
            self.refuse(Refusal.KEY)
            raise LinkError(f"{self.peer} has another key", Refusal.KEY)
        if self._is_full():
            self.refuse(Refusal.FULL)
            raise LinkError(f"{self.peer} is one too many", Refusal.FULL)
        if not self._calls:
            self.send(Frame(_Kind.PROOF, {"proof": self._proof(calls=False)}))
        self.is_proven = True
        self._heard_s = time.monotonic()
        self._link.max_bytes = MAX_FRAME_BYTES

    def _take_nonce(self, head: Mapping[str, Any], *, calls: bool) -> None:
        nonce = head.get("nonce")
        if not isinstance(nonce, str) or len(nonce) != 2 * _NONCE_BYTES or not nonce.isascii():
            raise self._foreign()
        self._nonces[calls] = nonce

    def _proof(self, *, calls: bool) -> str:
        """Return what proves that the end which called, or the one that listens, has the key."""
        words = ("graphnav", str(VERSION), self._service, "calls" if calls else "listens")
        message = "\n".join([*words, self._nonces[True], self._nonces[False]]).encode()
        return hmac.new(self._key, message, hashlib.sha256).hexdigest()

    def _refused(self, head: Mapping[str, Any]) -> LinkError:
        name = head.get("why")
        reason = Refusal[name] if isinstance(name, str) and name in Refusal.__members__ else Refusal.GONE
        return LinkError(f"{self.peer} refused the connection: {reason}", reason)

    def _gone(self, error: OSError) -> LinkError:
        return LinkError(f"the connection to {self.peer} is cut: {error.strerror or error}", Refusal.GONE)

    def _foreign(self) -> LinkError:
        return LinkError(f"{self.peer} sent something else than frames", Refusal.FOREIGN)


class HostListener:
    """Listens for hosts that have the key.

    ``address`` empty: all of this machine, IPv6 too. ``port`` 0: a free one. ``max_links``: proven ones. ``refused``
    counts closed connections by reason, ``last_refused`` is the address of the last one of each. Raises OSError.
    """

    failure = ""
    """There is none: it waits."""

    def __init__(self, address: str, port: int, key: bytes, service: str, max_links: int) -> None:
        self.refused: Counter[Refusal] = Counter()
        self.last_refused: dict[Refusal, str] = {}
        self._key, self._service, self._max_links = key, service, max_links
        self._unproven: list[HostLink] = []
        self._n_links = 0
        self._socket = _listening(address, port)
        self.port: int = self._socket.getsockname()[1]

    def pollables(self) -> list[tuple[int, int]]:
        """Return descriptors and the events that they wait for."""
        return [(self._socket.fileno(), select.POLLIN), *((one.fileno(), events_of(one)) for one in self._unproven)]

    def step(self, ready: Collection[int], n_links: int) -> list[HostLink]:
        """Go on with what is ready; return the links that are proven now.

        ``n_links``: of those returned before, how many are open.
        """
        self._n_links = n_links
        if self._socket.fileno() in ready:
            self._accept()
        proven, now_s = [], time.monotonic()
        for link in tuple(self._unproven):
            try:
                link.go_on(ready, now_s)
            except LinkError as error:
                self._drop(link, error.reason)
                continue
            if link.is_proven:
                self._unproven.remove(link)
                self._n_links += 1
                proven.append(link)
        return proven

    def lost(self, error: LinkError) -> None:
        """Learn that a link is lost; the host may call again."""

    def close(self) -> None:
        """Listen no more, and close what has proven nothing yet."""
        self._socket.close()
        for link in self._unproven:
            link.close()

    def _accept(self) -> None:
        """Take the connections that wait, at most as many as may be without proof."""
        for _ in range(_MAX_UNPROVEN):
            try:
                connection, _ = self._socket.accept()
            except OSError:  # none waits, it has gone again, or there are too many open files
                return
            try:
                link = HostLink(connection, self._key, self._service, calls=False, is_full=self._is_full)
            except (OSError, LinkError):
                connection.close()
                continue
            self._unproven.append(link)
            if len(self._unproven) > _MAX_UNPROVEN:
                self._drop(self._unproven[0], Refusal.CROWDED)

    def _is_full(self) -> bool:
        return self._n_links >= self._max_links

    def _drop(self, link: HostLink, reason: Refusal) -> None:
        self._unproven.remove(link)
        link.close()
        self.refused[reason] += 1
        self.last_refused[reason] = link.peer


class HostCaller:
    """Calls a host until it answers, and again after a cut, with pauses of 0.2 to 2 s.

    ``failure``: why it has not connected, empty while it has or makes the first attempt. It closes no connections
    of others: ``refused`` is as of a `HostListener`.
    """

    refused: Mapping[Refusal, int] = MappingProxyType({})
    last_refused: Mapping[Refusal, str] = MappingProxyType({})

    def __init__(self, host: str, port: int, key: bytes, service: str) -> None:
        self.failure = ""
        self.port = port
        self._host, self._key, self._service = host, key, service
        self._due_s, self._pause_s = 0.0, _PAUSE_S
        self._attempt: _Attempt | None = None
        self._link: HostLink | None = None
        self._lost_s: float | None = None

    def pollables(self) -> list[tuple[int, int]]:
        """Return descriptors and the events that they wait for."""
        return [] if self._link is None else [(self._link.fileno(), events_of(self._link))]

    def step(self, ready: Collection[int], n_links: int) -> list[HostLink]:
        """Go on with what is ready; return the link if it is proven now.

        ``n_links``: whether the one returned before is open, which is then all that is wanted.

        Raises
        ------
        LinkError
            The other end refused for a reason that time does not change.
        """
        now_s = time.monotonic()
        if n_links or now_s < self._due_s:
            return []
        if self._link is not None:
            return self._go_on(self._link, ready, now_s)
        if self._attempt is None:
            self._attempt = _Attempt(self._host, self.port)
        elif self._attempt.is_over:
            self._connected(self._attempt, now_s)
        return []

    def lost(self, error: LinkError) -> None:
        """Learn that the link is lost; raises the error if calling again would not help."""
        if error.reason in _FINAL:
            raise error
        self._lost_s = time.monotonic()
        self._wait(self._lost_s)

    def close(self) -> None:
        """Call no more."""
        if self._link is not None:
            self._link.close()
        if self._attempt is not None:
            self._attempt.give_up()

    def _connected(self, attempt: _Attempt, now_s: float) -> None:
        self._attempt = None
        if attempt.connection is None:
            self._fail(attempt.failure, now_s)
            return
        try:
            self._link = HostLink(attempt.connection, self._key, self._service, calls=True)
        except OSError as error:
            attempt.connection.close()
            self._fail(error.strerror or str(error), now_s)

    def _go_on(self, link: HostLink, ready: Collection[int], now_s: float) -> list[HostLink]:
        try:
            link.go_on(ready, now_s)
        except LinkError as error:
            self._link = None
            link.close()
            if error.reason in _FINAL:
                raise
            self.failure = str(error)
            self._wait(now_s)
            return []
        if not link.is_proven:
            return []
        self._link, self.failure, self._pause_s = None, "", _PAUSE_S
        link.after_s = None if self._lost_s is None else now_s - self._lost_s
        self._lost_s = None
        return [link]

    def _fail(self, why: str, now_s: float) -> None:
        self.failure = f"cannot connect to {self._host}, port {self.port}: {why}"
        self._wait(now_s)

    def _wait(self, now_s: float) -> None:
        """Wait before the next attempt, longer each time."""
        self._due_s = now_s + self._pause_s
        self._pause_s = min(2 * self._pause_s, _MAX_PAUSE_S)


class _Attempt:
    """Looks up a host's name and connects to it, in a thread: the first may take many seconds."""

    def __init__(self, host: str, port: int) -> None:
        self.connection: socket.socket | None = None
        self.failure = ""
        self._lock = threading.Lock()
        self._is_given_up = False
        self._thread = threading.Thread(target=self._connect, args=(host, port), name="graphnav-connect", daemon=True)
        self._thread.start()

    @property
    def is_over(self) -> bool:
        return not self._thread.is_alive()

    def give_up(self) -> None:
        """Close the connection that there is, or will be."""
        with self._lock:
            self._is_given_up = True
            if self.connection is not None:
                self.connection.close()

    def _connect(self, host: str, port: int) -> None:
        try:
            connection = socket.create_connection((host, port), _CONNECT_S)
        except (OSError, UnicodeError) as error:
            self.failure = getattr(error, "strerror", None) or str(error)
            return
        with self._lock:
            self.connection = connection
            if self._is_given_up:
                connection.close()


def _is_time(value: object) -> bool:
    return type(value) is int and 0 <= value < _END_NS


def events_of(link: HostLink) -> int:
    """Return the events that a link waits for."""
    return select.POLLIN | (select.POLLOUT if link.is_sending else 0)


def _listening(address: str, port: int) -> socket.socket:
    """Return a socket that listens and does not wait; IPv6 may be switched off."""
    listening = None
    if not address and socket.has_dualstack_ipv6():
        with suppress(OSError):
            listening = socket.create_server(("::", port), family=socket.AF_INET6, dualstack_ipv6=True)
    if listening is None:
        family = socket.AF_INET6 if ":" in address else socket.AF_INET
        listening = socket.create_server((address, port), family=family)
    listening.settimeout(0.0)
    return listening


def _shown(address: tuple[Any, ...]) -> str:
    """Return an address and a port; IPv4 also where the socket is IPv6."""
    host, port = str(address[0]).removeprefix("::ffff:"), address[1]
    return f"[{host}]:{port}" if ":" in host else f"{host}:{port}"
