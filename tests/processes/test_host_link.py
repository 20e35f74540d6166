"""Hosts that have the key are connected; whatever else comes is closed, counted, and costs little."""

from __future__ import annotations

import math
import random
import socket
import stat
import struct
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path

import pytest

from graphnav import UserError
from graphnav.processes import host_link
from graphnav.processes.frames import Frame, Link
from graphnav.processes.host_key import made_key, read_key
from graphnav.processes.host_link import HostCaller, HostLink, HostListener, LinkError, Refusal

KEY, OTHER_KEY = b"k" * 32, b"o" * 32


@pytest.fixture
def listener() -> Iterator[HostListener]:
    """Return what listens on a free port, for two links."""
    listening = HostListener("127.0.0.1", 0, KEY, "test", 2)
    yield listening
    listening.close()


def until(holds: Callable[[], object], *steps: Callable[[], object]) -> None:
    """Take steps until something holds, half a minute at most."""
    end_s = time.monotonic() + 30
    while not holds():
        assert time.monotonic() < end_s
        for step in steps:
            step()
        time.sleep(0.001)


def all_of(one: HostListener | HostCaller) -> list[int]:
    """Return all descriptors of what waits for links, as if they were ready."""
    return [fd for fd, _ in one.pollables()]


def until_refused(listener: HostListener, count: int) -> None:
    """Let a listener go on until it has closed so many connections."""
    until(lambda: listener.refused.total() >= count, lambda: listener.step(all_of(listener), 0))


class Pair:
    """A caller, and the links of both ends once it is connected."""

    def __init__(self, listener: HostListener, key: bytes = KEY, service: str = "test") -> None:
        self.listener = listener
        self.caller = HostCaller("127.0.0.1", listener.port, key, service)
        self.near: list[HostLink] = []
        self.far: list[HostLink] = []

    def step(self) -> None:
        """Go on with both."""
        self.far += self.listener.step(all_of(self.listener), len(self.far))
        self.near += self.caller.step(all_of(self.caller), len(self.near))

    def connect(self) -> tuple[HostLink, HostLink]:
        """Return both ends of a new connection."""
        until(lambda: self.near and self.far, self.step)
        return self.near[-1], self.far[-1]

    def close(self) -> None:
        """Close what there is."""
        self.caller.close()
        for link in (*self.near, *self.far):
            link.close()


@pytest.fixture
def pair(listener: HostListener) -> Iterator[Pair]:
    """Return a caller of the listener."""
    made = Pair(listener)
    yield made
    made.close()


def received(link: HostLink, *steps: Callable[[], object]) -> Frame:
    """Wait for a frame, and take steps meanwhile."""
    found: list[Frame] = []
    until(lambda: found, *steps, lambda: found.extend(filter(None, [link.receive()])))
    return found[0]


def test_frames_pass_in_both_ways_once_the_key_is_proven(pair: Pair) -> None:
    near, far = pair.connect()
    assert near.is_proven
    assert far.is_proven
    near.send(Frame(7, {"a": 1}, (b"there",)))
    far.send(Frame(8, [2], (b"back", bytes(70_000))))
    assert received(far) == Frame(7, {"a": 1}, (b"there",))
    assert received(near) == Frame(8, [2], (b"back", bytes(70_000)))
    assert not pair.listener.refused


def test_what_is_sent_at_once_after_the_proof_is_not_lost(listener: HostListener) -> None:
    pair = Pair(listener)
    until(lambda: pair.near, pair.step)
    pair.near[0].send(Frame(7, "first"))
    until(lambda: pair.far, pair.step)
    assert received(pair.far[0]) == Frame(7, "first")
    pair.close()


def test_another_key_is_refused_and_both_ends_know_why(listener: HostListener) -> None:
    pair = Pair(listener, OTHER_KEY)
    with pytest.raises(LinkError, match=rf"127.0.0.1:{listener.port} refused the connection: another key") as refused:
        until(lambda: False, pair.step)
    assert refused.value.reason is Refusal.KEY
    assert listener.refused == {Refusal.KEY: 1}
    assert listener.last_refused[Refusal.KEY].startswith("127.0.0.1:")
    assert not pair.far
    pair.close()


def test_an_end_that_listens_without_the_key_learns_nothing_and_is_left() -> None:
    """It has a nonce for the caller, and answers the caller's proof with what it cannot know."""
    with socket.create_server(("127.0.0.1", 0)) as listening:
        caller = HostCaller("127.0.0.1", listening.getsockname()[1], KEY, "test")
        until(caller.pollables, lambda: caller.step([], 0))
        link = Link(listening.accept()[0])
        link.send(Frame(240, {"graphnav": host_link.VERSION, "service": "test", "nonce": "0" * 64}))
        proofs: list[Frame] = []
        until(
            lambda: proofs,
            lambda: caller.step(all_of(caller), 0),
            lambda: proofs.extend(filter(None, [link.receive()])),
        )
        link.send(Frame(241, {"proof": proofs[0].head["proof"]}))  # its own, handed back
        with pytest.raises(LinkError, match="has another key"):
            until(lambda: False, lambda: caller.step(all_of(caller), 0))
        assert link.receive() == Frame(242, {"why": "KEY"})
        link.close()
        caller.close()


def test_another_service_and_another_version_are_told_apart(
    listener: HostListener, monkeypatch: pytest.MonkeyPatch
) -> None:
    pair = Pair(listener, service="something")
    with pytest.raises(LinkError, match="serves another thing than a something"):
        until(lambda: False, pair.step)
    pair.close()
    version = Pair(listener)
    until(lambda: version.caller.pollables() and len(version.listener.pollables()) > 1, version.step)
    newer = host_link.VERSION + 1
    monkeypatch.setattr(host_link, "VERSION", newer)
    with pytest.raises(LinkError, match=f"has another version of this protocol than {newer}"):
        until(lambda: False, version.step)
    version.close()


def test_no_more_are_served_than_there_is_room_for(listener: HostListener) -> None:
    links: list[HostLink] = []
    callers = [HostCaller("127.0.0.1", listener.port, KEY, "test") for _ in range(3)]
    connected: dict[int, HostLink] = {}

    def step() -> None:
        links.extend(listener.step(all_of(listener), len(links)))
        for k, caller in enumerate(callers):
            if new := caller.step(all_of(caller), k in connected):
                connected[k] = new[0]

    until(lambda: len(connected) == 2 and any(caller.failure for caller in callers), step)
    failures = [caller.failure for k, caller in enumerate(callers) if k not in connected]
    assert failures == [f"127.0.0.1:{listener.port} refused the connection: too many connections"]
    assert listener.refused[Refusal.FULL] >= 1
    links.pop().close()
    until(lambda: len(connected) == 3, step)
    for link in (*links, *connected.values()):
        link.close()


def framed(kind: int, head: bytes) -> bytes:
    """Return a frame without messages."""
    return struct.pack("<IBII", 9 + len(head), kind, len(head), 0) + head


HOSTILE = {
    "a web browser": b"GET / HTTP/1.1\r\nHost: robot\r\n\r\n",
    "ssh": b"SSH-2.0-OpenSSH_9.6\r\n",
    "a huge frame": struct.pack("<I", 1 << 30),
    "a frame larger than before a proof": struct.pack("<I", 513),
    "too short a frame": struct.pack("<I", 3),
    "messages before the proof": framed(17, b"[]"),
    "no JSON": framed(241, b"{,"),
    "no UTF-8": framed(241, b"\xff"),
    "deep JSON": framed(241, b"[" * 500),
    "a list": framed(241, b"[]"),
    "no nonce": framed(241, b'{"proof": "1"}'),
    "a nonce that is a number": framed(241, b'{"nonce": 12, "proof": "1"}'),
    "no proof": framed(241, b'{"nonce": "' + b"0" * 64 + b'"}'),
    "an answer to itself": framed(240, b"{}"),
    "alive before the proof": framed(243, b"null"),
    "zeros": bytes(64),
}


@pytest.mark.parametrize("data", HOSTILE.values(), ids=HOSTILE)
def test_hostile_bytes_are_closed_and_counted(data: bytes, listener: HostListener, pair: Pair) -> None:
    with socket.create_connection(("127.0.0.1", listener.port)) as other:
        other.sendall(data)
        until_refused(listener, 1)
        other.settimeout(30)
        with suppress(ConnectionResetError):
            while other.recv(4096):
                pass
    assert listener.refused == {Refusal.FOREIGN: 1}
    pair.connect()


def test_a_wrong_proof_is_refused_whatever_it_is(listener: HostListener, pair: Pair) -> None:
    for k, proof in enumerate((b"0" * 64, b"", b"\xc3\xa9", b"\\ud800")):
        with socket.create_connection(("127.0.0.1", listener.port)) as other:
            other.sendall(framed(241, b'{"nonce": "' + b"0" * 64 + b'", "proof": "' + proof + b'"}'))
            until_refused(listener, k + 1)
    assert listener.refused == {Refusal.KEY: 4}
    pair.connect()


def test_random_bytes_are_closed(listener: HostListener) -> None:
    chance = random.Random(3)
    for k in range(100):
        with socket.create_connection(("127.0.0.1", listener.port)) as other:
            n_bytes = chance.randrange(1, 2000)
            other.sendall(chance.randbytes(n_bytes))
        until_refused(listener, k + 1)
    assert listener.refused.total() == 100
    assert len(listener.pollables()) == 1


def test_who_proves_nothing_in_time_is_closed(
    listener: HostListener, pair: Pair, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(host_link, "_PROOF_S", 0.2)
    with socket.create_connection(("127.0.0.1", listener.port)) as other:
        for byte in framed(241, bytes(200))[:20]:  # never all of it
            other.sendall(bytes([byte]))
            listener.step(all_of(listener), 0)
        until_refused(listener, 1)
    assert listener.refused == {Refusal.SILENT: 1}
    pair.connect()


def test_connections_without_proof_do_not_keep_others_out(listener: HostListener, pair: Pair) -> None:
    others = [socket.create_connection(("127.0.0.1", listener.port)) for _ in range(40)]
    until(lambda: listener.refused[Refusal.CROWDED] == 24, lambda: listener.step(all_of(listener), 0))
    assert len(listener.pollables()) == 1 + 16
    pair.connect()
    for other in others:
        other.close()


def test_silence_is_a_cut_and_signs_of_life_prevent_it(pair: Pair, monkeypatch: pytest.MonkeyPatch) -> None:
    near, far = pair.connect()
    monkeypatch.setattr(host_link, "_SILENT_S", 0.5)
    monkeypatch.setattr(host_link, "_ALIVE_S", 0.05)
    end_s = time.monotonic() + 1.0
    while time.monotonic() < end_s:
        for link in (near, far):
            assert link.receive() is None
            link.tick(time.monotonic())
    with pytest.raises(LinkError, match=r"nothing has come from 127.0.0.1:\d+ for 0.5 s"):
        until(lambda: False, near.receive, lambda: near.tick(time.monotonic()))


def turn(*links: HostLink) -> None:
    """Let links go on that have nothing else to say."""
    for link in links:
        assert link.receive() is None
        link.tick(time.monotonic())


def test_both_ends_know_the_clock_of_the_other_one(pair: Pair, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(host_link, "_ALIVE_S", 0.01)
    near, far = pair.connect()
    ahead_ns = [3_600_000_000_000]
    far.wall_ns = lambda: time.time_ns() + ahead_ns[0]
    assert near.clock_state() is None

    def are_right(offset_s: float) -> bool:
        states = near.clock_state(), far.clock_state()
        if None in states:
            return False
        assert all(state is not None and state.round_trip_s > 0 for state in states)
        wrong_s = [abs(s.offset_s - o) - s.error_s for s, o in zip(states, (offset_s, -offset_s), strict=True) if s]
        return max(wrong_s) <= 0

    until(lambda: are_right(3600.0), lambda: turn(near, far))
    for k, step_s in enumerate((0.3, -3600.0), 1):
        ahead_ns[0] += round(step_s * 1e9)
        until(lambda k=k: near.clock.n_steps == k, lambda: turn(near, far))  # type: ignore[misc]
        assert near.clock.step_s == pytest.approx(step_s, abs=0.1), "within what busy processors make of a round trip"
        until(lambda: are_right(ahead_ns[0] * 1e-9), lambda: turn(near, far))
    assert far.clock.n_steps == 0, "its own clock was set"
    n_answers = far.clock.n_answers
    until(lambda: far.clock.n_answers > n_answers + 10, lambda: turn(near, far))
    assert (near.clock.n_steps, far.clock.n_steps) == (2, 0)


def test_an_answer_that_waits_for_what_is_sent_tells_for_how_long(pair: Pair) -> None:
    near, far = pair.connect()
    far.wall_ns = lambda: time.time_ns() + 5_000_000_000
    far._link.send(Frame(7, None, (bytes(24 << 20),)))
    assert far.is_sending
    near.tick(time.monotonic())
    asked_s = time.monotonic()
    until(lambda: far._question is not None, lambda: turn(far))
    came_s = time.monotonic()
    until(lambda: time.monotonic() - came_s > 0.1, lambda: turn(far))
    assert received(near, far.send_more).kind == 7
    until(lambda: near.clock.n_answers, lambda: turn(near, far))
    state = near.clock_state()
    assert state is not None
    assert abs(state.offset_s - 5.0) <= state.error_s
    assert state.round_trip_s <= time.monotonic() - asked_s - 0.1


HOSTILE_TIMES: dict[str, tuple[int, Callable[[int], object]]] = {
    "a boolean as a question": (243, lambda _: True),
    "a negative question": (243, lambda _: -1),
    "a fraction as a question": (243, lambda _: 0.5),
    "NaN as a question": (243, lambda _: math.nan),
    "a string as a question": (243, lambda _: "1"),
    "an object as a question": (243, lambda _: {}),
    "a huge question": (243, lambda _: 1 << 62),
    "an answer that is none": (244, lambda _: None),
    "an object as an answer": (244, lambda asked: {"0": asked}),
    "too short an answer": (244, lambda asked: [asked, 0]),
    "too long an answer": (244, lambda asked: [asked, 0, 1, 1]),
    "an answer to another question": (244, lambda asked: [asked + 1, 0, 1]),
    "NaN as a time": (244, lambda asked: [asked, 0, math.nan]),
    "infinity as a time": (244, lambda asked: [asked, math.inf, 1]),
    "a negative time": (244, lambda asked: [asked, 0, -1]),
    "held for less than nothing": (244, lambda asked: [asked, -1, 1]),
    "a huge time": (244, lambda asked: [asked, 0, 1 << 62]),
    "a time that is a boolean": (244, lambda asked: [asked, 0, True]),
    "a time that is a list": (244, lambda asked: [asked, [0], 1]),
    "another kind": (245, lambda _: None),
}


@pytest.mark.parametrize(("kind", "head"), HOSTILE_TIMES.values(), ids=HOSTILE_TIMES)
def test_times_that_are_none_are_closed(kind: int, head: Callable[[int], object], pair: Pair) -> None:
    near, far = pair.connect()
    far.tick(time.monotonic())
    assert far._asked_ns is not None
    near._link.send(Frame(kind, head(far._asked_ns)))
    with pytest.raises(LinkError, match="sent something else than frames") as closed:
        until(lambda: False, far.receive)
    assert closed.value.reason is Refusal.FOREIGN
    assert far.clock.n_answers == 0


def test_an_answer_counts_once(pair: Pair) -> None:
    near, far = pair.connect()
    far.tick(time.monotonic())
    answer = Frame(244, (far._asked_ns, 0, (1 << 62) - 1))
    for _ in range(2):
        near._link.send(answer)
    with pytest.raises(LinkError, match="sent something else than frames"):
        until(lambda: False, far.receive)
    assert far.clock.n_answers == 1
    state = far.clock_state()
    assert state is not None
    assert state.offset_s > 1e9


def test_a_cut_is_noticed_and_called_again_after(pair: Pair) -> None:
    near, far = pair.connect()
    assert near.after_s is None
    far.close()
    with pytest.raises(LinkError, match=r"closed the connection|is cut") as lost:
        until(lambda: False, near.receive)
    pair.near.clear()
    pair.far.clear()
    pair.caller.lost(lost.value)
    again, _ = pair.connect()
    assert again.after_s is not None
    near.close()


def test_what_cannot_be_reached_is_told_and_tried_again() -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        port = taken.getsockname()[1]
        caller = HostCaller("127.0.0.1", port, KEY, "test")
        until(lambda: caller.failure, lambda: caller.step([], 0))
        assert caller.failure == f"cannot connect to 127.0.0.1, port {port}: Connection refused"
    listening = HostListener("127.0.0.1", port, KEY, "test", 1)
    pair = Pair(listening)
    pair.caller = caller
    pair.connect()
    assert not caller.failure
    pair.close()
    listening.close()


def test_a_name_that_does_not_exist_is_told() -> None:
    caller = HostCaller("no.such.host.invalid", 1, KEY, "test")
    until(lambda: caller.failure, lambda: caller.step([], 0))
    assert caller.failure.startswith("cannot connect to no.such.host.invalid, port 1: ")
    caller.close()


def test_a_key_is_made_once_for_its_user_alone(tmp_path: Path) -> None:
    path = tmp_path / "state" / "hosts.key"
    key, is_new = made_key(path)
    assert is_new
    assert len(key) == 32
    assert stat.S_IMODE(path.stat().st_mode) == 0o600
    assert stat.S_IMODE(path.parent.stat().st_mode) == 0o700
    assert made_key(path) == (key, False)
    assert read_key(path) == key
    assert [file.name for file in path.parent.iterdir()] == ["hosts.key"]
    assert made_key(tmp_path / "other")[0] != key


@pytest.mark.parametrize(
    ("content", "mode", "told"),
    [
        (b"ab" * 32, 0o640, "other users may read or change the key in {path}\n  run chmod 600 {path}"),
        (b"ab" * 31, 0o600, "{path} does not contain a key\n  it has 64 hexadecimal digits: copy it again"),
        (b"\xff" * 64, 0o600, "{path} does not contain a key\n  it has 64 hexadecimal digits: copy it again"),
        (b"", 0o600, "{path} does not contain a key\n  it has 64 hexadecimal digits: copy it again"),
    ],
    ids=["readable", "short", "binary", "empty"],
)
def test_a_key_that_cannot_be_used_is_an_error(content: bytes, mode: int, told: str, tmp_path: Path) -> None:
    path = tmp_path / "key"
    path.write_bytes(content)
    path.chmod(mode)
    with pytest.raises(UserError) as error:
        read_key(path)
    assert str(error.value) == told.format(path=path)


def test_a_key_that_is_missing_is_an_error(tmp_path: Path) -> None:
    path = tmp_path / "key"
    with pytest.raises(UserError) as error:
        read_key(path)
    assert str(error.value) == (
        f"the key {path} does not exist\n"
        f"  'graphnav tunnel --serve' or 'run --host' on the other host makes one: copy it, with mode 0600, to {path}"
    )
    with pytest.raises(UserError, match=r"does not contain a key|cannot read"):
        read_key(tmp_path)
    with pytest.raises(UserError, match="cannot write the key to /proc/key"):
        made_key(Path("/proc/key"))
