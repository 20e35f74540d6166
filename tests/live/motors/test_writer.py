"""The pipe's writer never waits, keeps frames complete, and prefers what is new."""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator

import pytest

from graphnav.live.motors.frames import Frame, FrameReader, Kind
from graphnav.live.motors.writer import FrameWriter


class Pipe:
    """A pipe, its writer and what has come out of it."""

    def __init__(self) -> None:
        self.read_fd, write_fd = os.pipe()
        os.set_blocking(self.read_fd, False)
        self.writer = FrameWriter(os.fdopen(write_fd, "wb", buffering=0))
        self.reader = FrameReader()

    def read(self, n_bytes: int = 1 << 20) -> list[Frame]:
        """Return the frames among the next bytes."""
        return self.reader.feed(os.read(self.read_fd, n_bytes))

    def fill(self, data: bytes = bytes(1009)) -> int:
        """Send commands until the pipe is full; return the number that it took."""
        count = 0
        while self.writer.command(0, count, data):
            count += 1
        return count


@pytest.fixture
def pipe() -> Iterator[Pipe]:
    pipe = Pipe()
    yield pipe
    pipe.writer.close()
    os.close(pipe.read_fd)


def test_what_is_written_can_be_read(pipe: Pipe) -> None:
    assert pipe.writer.command(3, 1.5, b"go")
    assert pipe.writer.order(Kind.STOP, 2.5)
    assert pipe.writer.unread_bytes > 0
    assert pipe.read() == [Frame(Kind.COMMAND, 3, 1.5, b"go"), Frame(Kind.STOP, 0, 2.5, b"")]
    assert pipe.writer.unread_bytes == 0


def test_of_what_does_not_fit_the_newest_of_each_channel_waits(pipe: Pipe) -> None:
    count = pipe.fill()
    for k in range(100):
        assert not pipe.writer.command(0, 0.0, b"old %d" % k)
        assert not pipe.writer.command(1, 0.0, b"other %d" % k)
    assert len(pipe.read()) == count
    assert pipe.writer.command(0, 9.0, b"new")
    assert [(frame.channel, frame.payload) for frame in pipe.read()] == [(0, b"new"), (1, b"other 99")]


def test_an_order_replaces_commands_that_wait_and_goes_before_later_ones(pipe: Pipe) -> None:
    count = pipe.fill()
    assert not pipe.writer.order(Kind.STOP, 1.0)
    assert not pipe.writer.command(1, 2.0, b"later")
    assert len(pipe.read()) == count
    assert pipe.writer.command(2, 3.0, b"last")
    assert [(frame.kind, frame.payload) for frame in pipe.read()] == [
        (Kind.STOP, b""),
        (Kind.COMMAND, b"later"),
        (Kind.COMMAND, b"last"),
    ]


def test_many_orders_need_no_more_memory_and_the_last_is_kept(pipe: Pipe) -> None:
    pipe.fill()
    for _ in range(1000):
        pipe.writer.order(Kind.STOP, 1.0)
    pipe.writer.order(Kind.END, 2.0)
    pipe.read()
    pipe.writer.command(0, 3.0, b"")
    kinds = [frame.kind for frame in pipe.read()]
    assert kinds[-2:] == [Kind.END, Kind.COMMAND]
    assert len(kinds) <= 5


def test_a_frame_that_has_begun_is_completed(pipe: Pipe) -> None:
    large = os.urandom(200_000)
    assert not pipe.writer.command(0, 1.0, large)
    assert not pipe.writer.order(Kind.STOP, 2.0)
    got: list[Frame] = []
    while not got:
        got += pipe.read(10_000)
        pipe.writer.command(1, 3.0, b"small")
    while not pipe.writer.command(1, 4.0, b"small"):
        got += pipe.read()
    got += pipe.read()
    assert got[0].payload == large
    assert got[1].kind == Kind.STOP
    assert {frame.payload for frame in got[2:]} == {b"small"}


def test_a_pipe_without_a_reader_is_an_error(pipe: Pipe) -> None:
    os.close(pipe.read_fd)
    with pytest.raises(BrokenPipeError):
        pipe.writer.command(0, 0.0, b"x")
    pipe.read_fd = os.open(os.devnull, os.O_RDONLY)


def test_a_closed_pipe_is_an_error(pipe: Pipe) -> None:
    pipe.writer.close()
    assert pipe.writer.unread_bytes == 0
    with pytest.raises(OSError, match="Bad file descriptor"):
        pipe.writer.command(0, 0.0, b"")


def test_a_signal_handler_may_order_while_a_command_is_written(pipe: Pipe) -> None:
    ordered = 0

    def handler(*_: object) -> None:
        nonlocal ordered
        ordered += 1
        pipe.writer.order(Kind.STOP, 0.0)

    old = signal.signal(signal.SIGALRM, handler)
    signal.setitimer(signal.ITIMER_REAL, 2e-4, 2e-4)
    got: list[Frame] = []
    try:
        while ordered < 300:
            pipe.writer.command(0, 0.0, bytes(5000))
            with_rest = pipe.reader.feed(os.read(pipe.read_fd, 1 << 20)) if pipe.writer.unread_bytes else []
            got += with_rest
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, old)
    pipe.writer.command(0, 0.0, b"")
    got += pipe.read()
    stops = sum(frame.kind == Kind.STOP for frame in got)
    assert 0 < stops <= ordered  # of those that wait in a full pipe only the newest are kept
    assert {len(frame.payload) for frame in got if frame.kind == Kind.COMMAND} <= {5000, 0}
