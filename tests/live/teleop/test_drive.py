"""Keys to a twist: bytes to keys, keys to commands, and silence once they are let go."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from graphnav.core.bus import Bus
from graphnav.core.codec import decode
from graphnav.core.messages import Stop, Twist
from graphnav.live.teleop import Drive, Key, Keys, Session

F, B, L, R = Key.FORWARD, Key.BACK, Key.LEFT, Key.RIGHT


@pytest.mark.parametrize(
    ("typed", "keys"),
    [
        (b"wasd", [F, L, B, R]),
        (b"ijkl", [F, L, B, R]),
        (b"WASD", [F, L, B, R]),
        (b"\x1b[A\x1b[D\x1b[B\x1b[C", [F, L, B, R]),
        (b"\x1bOA\x1bOD\x1bOB\x1bOC", [F, L, B, R]),
        (b" xrq+-=_", [Key.HALT, Key.STOP, Key.ARM, Key.QUIT, Key.FASTER, Key.SLOWER, Key.FASTER, Key.SLOWER]),
        (b"\x1b[1;5A", []),
        (b"\x1b[3~\x1b[15~", []),
        (b"\x1b[200~", []),
        (b"zZ7\t\n\xff\xc3\xa9\x00", []),
        (b"\x1bw", [F]),
        (b"\x1b\x1b[A", [F]),
        (b"\x1b[" + b"1" * 40, []),
    ],
)
def test_bytes_are_keys(typed: bytes, keys: list[Key]) -> None:
    assert Keys().feed(typed) == keys


def test_a_sequence_may_come_in_pieces() -> None:
    decoder = Keys()
    assert [decoder.feed(bytes([byte])) for byte in b"\x1b[Aw\x1b[1;2Dd"] == [
        [], [], [F], [F], [], [], [], [], [], [], [R],
    ]  # fmt: skip


def twist_of(drive: Drive, now_s: float) -> tuple[float, float] | None:
    """Return what a drive would publish."""
    command = drive.command(now_s)
    return None if command is None else (command.v_mps, command.omega_radps)


@pytest.mark.parametrize(("key", "twist"), [(F, (0.3, 0)), (B, (-0.3, 0)), (L, (0, 0.8)), (R, (0, -0.8))])
def test_a_key_drives_for_its_time_then_zero_then_silence(key: Key, twist: tuple[float, float]) -> None:
    drive = Drive(0.3, 0.8, timeout_s=0.3)
    assert twist_of(drive, 9.9) is None
    drive.press(key, 10.0)
    assert twist_of(drive, 10.0) == twist
    assert twist_of(drive, 10.29) == twist
    assert twist_of(drive, 10.31) == (0, 0)
    assert twist_of(drive, 10.59) == (0, 0)
    assert twist_of(drive, 10.61) is None


def test_repeats_keep_it_driving() -> None:
    drive = Drive(0.3, 0.8, timeout_s=0.3)
    for k in range(20):
        drive.press(F, 10 + 0.2 * k)
        assert twist_of(drive, 10 + 0.2 * k + 0.19) == (0.3, 0)


def test_forward_and_turn_make_a_curve_while_both_are_fresh() -> None:
    drive = Drive(0.3, 0.8, timeout_s=0.3)
    drive.press(F, 10.0)
    drive.press(L, 10.2)
    assert twist_of(drive, 10.25) == (0.3, 0.8)
    assert twist_of(drive, 10.4) == (0, 0.8)


@pytest.mark.parametrize("key", [Key.HALT, Key.STOP])
def test_halt_is_at_once(key: Key) -> None:
    drive = Drive(0.3, 0.8, timeout_s=0.3)
    drive.press(F, 10.0)
    drive.press(key, 10.05)
    assert twist_of(drive, 10.05) == (0, 0)
    assert twist_of(drive, 10.36) is None


def test_the_speeds_change_by_a_tenth() -> None:
    drive = Drive(0.3, 0.8, timeout_s=0.3)
    drive.press(Key.FASTER, 10.0)
    assert [drive.speed_mps, drive.turn_radps] == pytest.approx([0.33, 0.88])
    assert twist_of(drive, 10.0) is None, "it drives nowhere by itself"
    drive.press(Key.SLOWER, 10.0)
    assert [drive.speed_mps, drive.turn_radps] == pytest.approx([0.3, 0.8])


class Typist:
    """A keyboard and a clock: what is typed when, in seconds from the start."""

    def __init__(self, typed: list[tuple[float, bytes | None]], stall_s: float = 0.0) -> None:
        self.now_s = 50.0
        self._typed: Iterator[tuple[float, bytes | None]] = iter(typed)
        self._next = next(self._typed)
        self._stall_s = stall_s

    def read(self, timeout_s: float) -> bytes | None:
        """Let the time pass until the next key, or until the timeout."""
        at_s = 50.0 + self._next[0]
        if at_s > self.now_s + timeout_s:
            self.now_s += max(0.0, timeout_s)
            return b""
        self.now_s = max(self.now_s, at_s) + self._stall_s
        data = self._next[1]
        self._next = next(self._typed, (1e9, None))
        return data


class Heard:
    """Messages of a session on a bus of this process, with the time since its start."""

    def __init__(self, typist: Typist, rate_hz: float = 20) -> None:
        self.twists: list[tuple[float, float, float]] = []
        self.stops: list[tuple[int, bool]] = []
        self.lines: list[str] = []
        self.bus = Bus()
        self.bus.subscribe("TELEOP", self._hear_twist)
        self.bus.subscribe("STOP", self._hear_stop)
        self._typist = typist
        drive = Drive(0.3, 0.8, timeout_s=0.3)
        session = Session(
            self.bus, "TELEOP", "STOP", drive, rate_hz, self.lines.append, self._now_s, lambda: 1_000_000_000
        )
        session.run(typist)
        self.bus.drain()
        self.bus.close()

    def _now_s(self) -> float:
        self.bus.drain()
        return self._typist.now_s

    def _hear_twist(self, _channel: str, data: bytes) -> None:
        utime, seq, twist = decode(Twist, data)
        assert (utime, seq) == (1_000_000, len(self.twists))
        self.twists.append((round(self._typist.now_s - 50, 3), twist.v_mps, twist.omega_radps))

    def _hear_stop(self, _channel: str, data: bytes) -> None:
        _, seq, stop = decode(Stop, data)
        self.stops.append((seq, stop.engaged))


def test_nothing_is_published_before_a_key() -> None:
    heard = Heard(Typist([(5.0, b"q")]))
    assert (heard.twists, heard.stops) == ([], [])


def test_a_key_is_published_at_the_rate_then_zero_then_nothing() -> None:
    heard = Heard(Typist([(1.02, b"w"), (5.0, None)]))
    assert [time_s for time_s, _, _ in heard.twists] == [round(1.02 + 0.05 * k, 3) for k in range(13)]
    assert [(v, omega) for _, v, omega in heard.twists] == [(0.3, 0)] * 7 + [(0, 0)] * 6
    assert heard.lines == [
        "keys give 0.30 m/s, 0.80 rad/s; publishing nothing",
        "keys give 0.30 m/s, 0.80 rad/s; publishing +0.30 m/s, +0.00 rad/s",
        "keys give 0.30 m/s, 0.80 rad/s; publishing +0.00 m/s, +0.00 rad/s",
        "keys give 0.30 m/s, 0.80 rad/s; publishing nothing",
    ]


@pytest.mark.parametrize("end", [b"q", None])
def test_the_end_of_a_drive_is_zero(end: bytes | None) -> None:
    heard = Heard(Typist([(1.0, b"w"), (1.1, end)]))
    assert [(v, omega) for _, v, omega in heard.twists[-4:]] == [(0.3, 0), (0, 0), (0, 0), (0, 0)]


def test_a_stop_is_published_once_and_so_is_arming() -> None:
    heard = Heard(Typist([(1.0, b"w"), (1.1, b"x"), (2.0, b"r"), (3.0, b"q")]))
    assert heard.stops == [(0, True), (1, False)]
    assert (1.1, 0, 0) in heard.twists
    assert [line.partition(";")[0] for line in heard.lines][2:] == ["stop published"] * 2 + ["armed again"]


def test_keys_that_waited_while_the_process_was_halted_do_not_drive() -> None:
    heard = Heard(Typist([(1.0, b"wwwr"), (9.0, b"q")], stall_s=1.0))
    assert (heard.twists, heard.stops) == ([], [])
    heard = Heard(Typist([(1.0, b"wwwx"), (9.0, b"q")], stall_s=1.0))
    assert {(v, omega) for _, v, omega in heard.twists} == {(0, 0)}
    assert heard.stops == [(0, True)]


def test_a_speed_is_followed_by_a_zero_however_late() -> None:
    drive = Drive(0.3, 0.8, timeout_s=0.3)
    drive.press(F, 10.0)
    assert twist_of(drive, 10.1) == (0.3, 0)
    assert twist_of(drive, 15.0) == (0, 0)
    assert twist_of(drive, 15.1) is None
