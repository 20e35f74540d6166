"""Frames arrive as they were sent, and nothing else is taken for one."""

from __future__ import annotations

import os
import socket
import struct
import threading
from collections.abc import Iterator

import numpy as np
import pytest

from graphnav import Image
from graphnav.core.codec import decode, encode
from graphnav.core.machine import peer_of
from graphnav.core.messages import Gap
from graphnav.processes.frames import Frame, Kind, Link, receive, send


@pytest.fixture
def links() -> Iterator[tuple[socket.socket, socket.socket]]:
    """Return two ends of a connection."""
    ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_STREAM)
    with ours, theirs:
        yield ours, theirs


@pytest.mark.parametrize(
    "messages",
    [(), (b"",), (b"a", b"", b"bc"), (bytes(3_000_000), b"x", bytes(70_000)), (b"m" * 100,) * 2000],
    ids=["none", "empty", "small", "large", "many"],
)
def test_a_frame_arrives_as_it_was_sent(
    links: tuple[socket.socket, socket.socket], messages: tuple[bytes, ...]
) -> None:
    frame = Frame(Kind.FIRE, [3, 1_000_000, [None, [0.1 + 0.2, True], []]], messages)
    sender = threading.Thread(target=send, args=(links[0], frame))
    sender.start()
    assert receive(links[1]) == frame
    sender.join()


def test_the_end_of_the_other_side_is_told(links: tuple[socket.socket, socket.socket]) -> None:
    links[0].sendall(struct.pack("<I", 100) + b"begun")
    links[0].close()
    with pytest.raises(EOFError):
        receive(links[1])


def test_a_link_waits_neither_for_a_reader_nor_for_the_rest_of_a_frame(
    links: tuple[socket.socket, socket.socket],
) -> None:
    link, theirs = Link(links[0]), links[1]
    frame, small = Frame(Kind.FIRE, [1], (bytes(3_000_000), b"x")), Frame(Kind.FIRE, [2], (b"y",))
    link.send(frame)  # nothing reads
    link.send(small)
    assert link.is_sending
    received: list[Frame] = []
    reader = threading.Thread(target=lambda: received.extend((receive(theirs), receive(theirs))))
    reader.start()
    while link.is_sending:
        link.send_more()
    reader.join()
    assert received == [frame, small]

    sent: list[bytes] = []
    ours, other = socket.socketpair(socket.AF_UNIX, socket.SOCK_STREAM)
    with ours, other:
        send(ours, small)
        sent.append(other.recv(1000))
    for k, byte in enumerate(sent[0] * 2):
        assert link.receive() is None
        theirs.sendall(bytes([byte]))
        if (k + 1) % len(sent[0]) == 0:
            assert link.receive() == small
    theirs.close()
    with pytest.raises(EOFError):
        link.receive()


@pytest.mark.parametrize(
    "data",
    [
        struct.pack("<I", 2**31),
        struct.pack("<I", 3),
        struct.pack("<IBII", 11, 2, 4_000_000, 0) + b"{}",
        struct.pack("<IBII", 11, 2, 2, 1_000_000) + b"{}",
        struct.pack("<IBIII", 17, 2, 2, 1, 9) + b"{}aa",
        struct.pack("<IBII", 11, 2, 2, 0) + b"{,",
        struct.pack("<IBII", 100_009, 2, 100_000, 0) + b"[" * 100_000,
    ],
    ids=["long", "short", "head", "number", "size", "json", "deep"],
)
def test_what_is_no_frame_is_refused(links: tuple[socket.socket, socket.socket], data: bytes) -> None:
    links[0].sendall(data)
    with pytest.raises(ValueError, match=r"frame|Expecting"):
        receive(links[1])


def test_a_link_takes_no_longer_frames_than_it_is_told(links: tuple[socket.socket, socket.socket]) -> None:
    link, frame = Link(links[0], max_bytes=100), Frame(Kind.FIRE, "a" * 89)
    send(links[1], frame)
    assert link.receive() == frame
    assert link.n_received == 104
    send(links[1], Frame(Kind.FIRE, "a" * 90))
    with pytest.raises(ValueError, match="a frame of 101 bytes, expected 9 to 100"):
        link.receive()


def test_the_other_side_is_known(links: tuple[socket.socket, socket.socket]) -> None:
    assert peer_of(links[0]) == (os.getpid(), os.getuid())


def test_messages_of_a_link_do_not_change_when_it_reads_the_next_frame(
    links: tuple[socket.socket, socket.socket],
) -> None:
    link = Link(links[0])
    send(links[1], Frame(Kind.ANSWER, {}, (b"a" * 1000,)))
    first = link.receive()
    send(links[1], Frame(Kind.ANSWER, {}, (b"b" * 1000,)))
    assert link.receive() == Frame(Kind.ANSWER, {}, (b"b" * 1000,))
    assert first == Frame(Kind.ANSWER, {}, (b"a" * 1000,))


def test_a_message_is_read_where_it_has_arrived(links: tuple[socket.socket, socket.socket]) -> None:
    told = Gap(from_us=1, n_messages=2, reason="no room (\N{DEGREE SIGN})")
    send(
        links[0], Frame(Kind.FIRE, None, (encode(told, 5, 6), encode(Image(pixels=np.eye(400, dtype=np.uint8)), 7, 8)))
    )
    text, picture = receive(links[1]).messages
    assert decode(Gap, text)[2].reason == told.reason
    pixels = decode(Image, picture)[2].pixels
    assert np.shares_memory(pixels, np.frombuffer(picture, np.uint8))
    assert np.array_equal(pixels, np.eye(400, dtype=np.uint8))
