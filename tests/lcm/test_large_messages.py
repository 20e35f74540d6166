"""Messages above one packet: LCM's packets, in order, also when the process that sends them dies or hangs."""

from __future__ import annotations

import os
import queue
import random
import shutil
import signal
import socket
import struct
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import closing
from pathlib import Path
from urllib.parse import urlsplit

import lcm
import numpy as np
import pytest

from graphnav import Image
from graphnav.core.bus import Bus
from graphnav.core.catalog import Catalog
from graphnav.core.codec import encode
from graphnav.core.graph import load_graph
from graphnav.core.large_messages import child
from graphnav.core.large_messages.child import FRAGMENT_BYTES, PACKET_BYTES, packets
from graphnav.live.clock import LiveClock
from graphnav.live.outlet import Outlet, bus_send

CHANNELS = ("C", "CAMERA", "n" * 63)
PATIENCE_S = 30.0
RNG = random.Random(7)


def sizes_of(channel: str) -> list[int]:
    """Return the sizes around which the number of packets of a message changes, and some others."""
    name = len(channel) + 1
    edges = [PACKET_BYTES, 2 * FRAGMENT_BYTES, 3 * FRAGMENT_BYTES]
    return [edge - name + by for edge in edges for by in (-1, 0, 1)] + [
        RNG.randrange(70_000, 400_000) for _ in range(4)
    ]


def until(holds: Callable[[], object]) -> None:
    end_s = time.monotonic() + PATIENCE_S
    while not holds():
        assert time.monotonic() < end_s, "it never came to that"
        time.sleep(0.005)


class Python:
    """An unmodified python-lcm receiver."""

    def __init__(self, url: str) -> None:
        self.received: list[tuple[str, bytes]] = []
        self._lcm = lcm.LCM(f"{url}&recv_buf_size=2097152")
        heard = self._lcm.subscribe("(?!LCM_SELF_TEST).*", lambda *message: self.received.append(message))
        heard.set_queue_capacity(0)
        self._lcm.handle_timeout(1)
        self.received.clear()

    def wait_for(self, count: int) -> list[tuple[str, bytes]]:
        end_s = time.monotonic() + PATIENCE_S
        while len(self.received) < count and time.monotonic() < end_s:
            self._lcm.handle_timeout(20)
        return self.received


@pytest.fixture
def bus(group: str) -> Iterator[Bus]:
    """Return a bus that keeps what it is told."""
    made = Bus(group, NOTICES.put)
    yield made
    made.close()


NOTICES: queue.Queue[str] = queue.Queue()


def senders(parent: int) -> list[int]:
    """Return the processes that send large messages for a process."""
    found = []
    for folder in Path("/proc").iterdir():
        try:
            command, status = (folder / "cmdline").read_bytes(), (folder / "stat").read_text()
        except OSError:
            continue
        state, ppid = status.rpartition(")")[2].split()[:2]
        if child.__file__.encode() in command and int(ppid) == parent and state != "Z":
            found.append(int(folder.name))
    return found


def own_sender() -> int:
    until(lambda: senders(os.getpid()))
    (pid,) = senders(os.getpid())
    return pid


@pytest.mark.parametrize("channel", CHANNELS)
def test_the_packets_are_those_of_liblcm(group: str, channel: str) -> None:
    host, port = urlsplit(group).hostname, urlsplit(group).port
    assert host is not None
    sender = lcm.LCM(group)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as wire:
        wire.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        wire.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 2_097_152)
        wire.bind((host, port))
        wire.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, socket.inet_aton(host) + bytes(4))
        wire.settimeout(PATIENCE_S)
        for size in sizes_of(channel):
            data = RNG.randbytes(size)
            sender.publish(channel, data)
            first = wire.recv(65_536)
            (number,) = struct.unpack_from(">I", first, 4)
            mine = [b"".join(parts) for parts in packets(channel.encode(), memoryview(data), number)]
            assert mine == [first, *(wire.recv(65_536) for _ in mine[1:])]


def test_unmodified_receivers_get_every_byte(group: str, bus: Bus) -> None:
    receiver, own = Python(group), list[tuple[str, bytes]]()
    sent = [(channel, RNG.randbytes(size)) for channel in CHANNELS for size in sizes_of(channel)]
    with closing(Bus(group)) as listener:
        listener.subscribe_all(lambda channel, data: own.append((channel, data)))
        for channel, data in sent:
            bus.send(channel, data)
        assert receiver.wait_for(len(sent)) == sent
        until(lambda: listener.handle(0.01) and len(own) == len(sent))
    assert own == sent
    assert not bus.overtaken


def test_later_messages_of_a_channel_do_not_pass_a_large_one(group: str, bus: Bus) -> None:
    receiver = Python(group)
    large, small = RNG.randbytes(900_000), [b"%d" % k for k in range(5)]
    bus.send("x", large, newest_only=True)
    for data in small:
        bus.send("x", data)
    assert receiver.wait_for(6) == [("x", large), *(("x", data) for data in small)]


def test_the_newest_large_message_of_each_channel_is_sent_and_the_others_are_counted(group: str, bus: Bus) -> None:
    receiver = Python(group)
    bus.expect_large()
    bus.send("ready", bytes(70_000))
    pid = own_sender()
    os.kill(pid, signal.SIGSTOP)
    for k in range(5):
        for channel in ("a", "b"):
            bus.send(channel, bytes([k]) * 300_000, newest_only=True)
    os.kill(pid, signal.SIGCONT)
    received = receiver.wait_for(3)[1:]
    assert [(channel, data[0], len(data)) for channel, data in received] == [("a", 4, 300_000), ("b", 4, 300_000)]
    bus.send("z", b"")  # reads the answers
    assert bus.overtaken == {"a": 4, "b": 4}


def test_an_output_counts_what_newer_pictures_replaced(group: str, bus: Bus) -> None:
    receiver, clock = Python(group), LiveClock()
    target = load_graph("robot_live", Catalog()).outputs["robot.image"]
    outlet = Outlet(target, clock, bus_send(bus, NOTICES.put), bus.overtaken)
    images = [Image(pixels=np.full((480, 640), k, np.uint8)) for k in range(4)]
    sent = [encode(image, k, k) for k, image in enumerate(images)]
    outlet.publish(images[0], sent[0], 0, clock.now_s(), clock.now_s())
    assert receiver.wait_for(1) == [("CAMERA", sent[0])]
    os.kill(pid := own_sender(), signal.SIGSTOP)
    for k in (1, 2, 3):
        outlet.publish(images[k], sent[k], k, clock.now_s(), clock.now_s())
    os.kill(pid, signal.SIGCONT)
    assert receiver.wait_for(2) == [("CAMERA", sent[0]), ("CAMERA", sent[3])]
    bus.send("z", b"")  # reads the answers
    assert (outlet.sent, outlet.overtaken, outlet.refused) == (2, 2, 0)


def test_what_finds_no_room_is_counted(bus: Bus) -> None:
    bus.send("ready", bytes(70_000))
    os.kill(own_sender(), signal.SIGSTOP)
    for _ in range(4):
        bus.send("x", bytes(child.MEMORY_BYTES // 2 - 1), newest_only=True)
    os.kill(own_sender(), signal.SIGKILL)
    until(lambda: not senders(os.getpid()))
    bus.send("y", b"")
    assert bus.overtaken == {"x": 4}
    assert NOTICES.get_nowait() == (
        "the process that sends messages above one packet died (status -9): it is started again"
    )


def test_a_process_that_dies_is_replaced_once_and_then_messages_leave_in_bursts(group: str, bus: Bus) -> None:
    receiver, data = Python(group), [RNG.randbytes(150_000 + k) for k in range(3)]
    for k in range(3):
        bus.send("x", data[k])
        assert receiver.wait_for(k + 1)[-1] == ("x", data[k])
        if pids := senders(os.getpid()):
            os.kill(pids[0], signal.SIGKILL)
            until(lambda: not senders(os.getpid()))
    assert NOTICES.get_nowait().endswith(" died (status -9): it is started again")
    assert NOTICES.get_nowait().endswith(" died (status -9): these now leave in bursts, without gaps")
    assert NOTICES.empty()
    assert not bus.overtaken


@pytest.mark.parametrize("newest_only", [False, True])
def test_a_process_that_hangs_is_replaced(
    group: str, bus: Bus, monkeypatch: pytest.MonkeyPatch, *, newest_only: bool
) -> None:
    receiver = Python(group)
    bus.send("x", b"0" * 70_000)
    monkeypatch.setattr("graphnav.core.large_messages.sender._PATIENCE_S", 1.0)
    os.kill(own_sender(), signal.SIGSTOP)
    if newest_only:
        bus.send("x", b"1" * 80_000, newest_only=True)
        time.sleep(1.1)
    bus.send("x", b"2" * 90_000, newest_only=newest_only)
    assert receiver.wait_for(2) == [("x", b"0" * 70_000), ("x", b"2" * 90_000)]
    assert bus.overtaken == ({"x": 1} if newest_only else {})
    assert NOTICES.get_nowait().endswith(" does not answer (status -9): it is started again")


def test_without_a_process_messages_leave_in_bursts(group: str, bus: Bus, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sys.executable", "/no/python")
    receiver = Python(group)
    for k in range(2):
        bus.send("x", b"%d" % k * 80_000)
    assert receiver.wait_for(2) == [("x", b"%d" % k * 80_000) for k in range(2)]
    assert NOTICES.get_nowait().startswith("the process that sends messages above one packet cannot be started: ")
    assert NOTICES.empty()


FORKED = """
import os, sys, time
from graphnav.core.bus import Bus
bus = Bus(sys.argv[1])
bus.send("x", bytes(100_000))
if os.fork() == 0:
    time.sleep(60)
    os._exit(0)
print(os.getpid(), flush=True)
time.sleep(60)
"""


def test_the_process_ends_with_the_program_even_if_a_fork_of_that_lives(group: str) -> None:
    with subprocess.Popen(
        [sys.executable, "-c", FORKED, group], stdout=subprocess.PIPE, start_new_session=True
    ) as program:
        assert program.stdout is not None
        program.stdout.readline()
        (pid,) = senders(program.pid)
        program.kill()
        until(lambda: not Path(f"/proc/{pid}").exists())
        os.killpg(program.pid, signal.SIGKILL)


REFUSED = """
import subprocess
from graphnav.core.bus import Bus
from graphnav.core.errors import BusError
subprocess.run(Bus.MAKE_ROUTE, shell=True, check=True)
bus = Bus("udpm://239.255.77.1:7667")
bus.send("x", bytes(100_000))
subprocess.run(["ip", "route", "del", "224.0.0.0/4"], check=True)
for newest_only in (False, True, True):
    try:
        bus.send("x", bytes(100_000), newest_only=newest_only)
        if newest_only:
            bus.send("x", b"")
        print("sent")
    except BusError as error:
        print(error)
"""


def test_what_the_network_refuses_is_an_error() -> None:
    unshare = shutil.which("unshare")
    if unshare is None or subprocess.run([unshare, "-rn", "true"], capture_output=True, check=False).returncode:
        pytest.skip("this machine gives no network namespace to try it in")
    done = subprocess.run([unshare, "-rn", sys.executable, "-c", REFUSED], capture_output=True, text=True, check=False)
    assert "cannot publish 100000 bytes on 'x': [Errno 101] Network is unreachable" in done.stdout.splitlines()
    assert not done.stderr
