"""The bus: lockstep delivery inside a process, the group's defaults between processes."""

from __future__ import annotations

import gc
import shutil
import socket
import subprocess
import sys
import weakref
from urllib.parse import urlsplit

import pytest

from graphnav.core.bus import Bus
from graphnav.core.errors import BusError


def test_what_is_published_arrives_in_order_when_drained() -> None:
    bus, got = Bus(), list[tuple[str, bytes]]()
    bus.subscribe("robot.image", lambda channel, data: got.append((channel, data)))
    bus.subscribe("flow.flow", lambda channel, data: got.append((channel, data)))
    sent = [("robot.image", b"1"), ("flow.flow", b"2"), ("robot.image", b"3")]
    for channel, data in sent:
        bus.publish(channel, data)
    assert got == []
    assert bus.drain() == 3
    assert got == sent


def test_more_messages_wait_than_lcm_would_queue() -> None:
    bus, got = Bus(), list[bytes]()
    bus.subscribe("x", lambda _, data: got.append(data))
    sent = [b"%d" % k for k in range(500)]
    for data in sent:
        bus.publish("x", data)
    bus.drain()
    assert got == sent


def test_a_handler_may_publish_and_the_drain_goes_on() -> None:
    bus, got = Bus(), list[bytes]()
    bus.subscribe("a", lambda _, data: bus.publish("b", data + b"!"))
    bus.subscribe("b", lambda _, data: got.append(data))
    bus.publish("a", b"hello")
    assert bus.drain() == 2
    assert got == [b"hello!"]


def test_a_channel_is_a_name_not_a_pattern() -> None:
    bus, got = Bus(), list[str]()
    bus.subscribe("a.b*", lambda channel, _: got.append(channel))
    for channel in ("a.b*", "axb*", "a.bbb", "a.b", "xa.b*", "a.b*x"):
        bus.publish(channel, b"")
    bus.drain()
    assert got == ["a.b*"]


def test_all_channels_can_be_heard() -> None:
    bus, got = Bus(), list[str]()
    bus.subscribe_all(lambda channel, _: got.append(channel))
    names = ["a.b", "C", "two\nlines", "\r\x1b[2J", " "]
    for name in names:
        bus.publish(name, b"")
    bus.drain()
    assert got == names


def test_a_message_reaches_every_handler_and_counts_once() -> None:
    bus, got = Bus(), list[str]()
    bus.subscribe("x", lambda *_: got.append("first"))
    bus.subscribe("x", lambda *_: got.append("second"))
    bus.subscribe_all(lambda *_: got.append("all"))
    bus.publish("x", b"")
    bus.publish("y", b"")
    assert bus.drain() == 2
    assert sorted(got) == ["all", "all", "first", "second"]


def test_messages_can_be_taken_one_by_one() -> None:
    bus, got = Bus(), list[bytes]()
    bus.subscribe("x", lambda _, data: got.append(data))
    bus.publish("x", b"1")
    bus.publish("x", b"2")
    assert bus.handle(0)
    assert got == [b"1"]
    assert bus.drain() == 1
    assert not bus.handle(10.0)


def test_an_exception_of_a_handler_comes_out_and_the_rest_stays() -> None:
    bus, got = Bus(), list[bytes]()

    def handler(_channel: str, data: bytes) -> None:
        if data == b"bad":
            raise ValueError("no good")
        got.append(data)

    bus.subscribe("x", handler)
    for data in (b"1", b"bad", b"2"):
        bus.publish("x", data)
    with pytest.raises(ValueError, match="no good"):
        bus.drain()
    assert bus.drain() == 1
    assert got == [b"1", b"2"]


def test_two_buses_in_a_process_do_not_hear_each_other() -> None:
    one, other, got = Bus(), Bus(), list[bytes]()
    other.subscribe("x", lambda _, data: got.append(data))
    one.publish("x", b"")
    assert one.drain() == other.drain() == 0
    assert got == []


@pytest.mark.parametrize(
    ("url", "wanted"),
    [
        ("memq://", "memq://"),
        ("udpm://", "udpm://239.255.76.67:7667?ttl=0&recv_buf_size=2097152"),
        (Bus.GROUP, "udpm://239.255.76.67:7667?ttl=0&recv_buf_size=2097152"),
        ("udpm://239.1.2.3:99?ttl=1", "udpm://239.1.2.3:99?ttl=1&recv_buf_size=2097152"),
        ("udpm://239.1.2.3", "udpm://239.1.2.3:7667?ttl=0&recv_buf_size=2097152"),
        ("udpm://239.1.2.3:?ttl=1", "udpm://239.1.2.3:7667?ttl=1&recv_buf_size=2097152"),
        ("udpm://239.1.2.3:99?recv_buf_size=5", "udpm://239.1.2.3:99?ttl=0&recv_buf_size=5"),
    ],
)
def test_a_group_stays_on_the_machine_unless_told(url: str, wanted: str) -> None:
    assert Bus.with_defaults(url) == wanted


def test_a_message_crosses_the_group(group: str) -> None:
    sender, receiver, got = Bus(group), Bus(group), list[tuple[str, bytes]]()
    receiver.subscribe("robot.image", lambda channel, data: got.append((channel, data)))
    sender.publish("robot.image", bytes(100_000))
    assert receiver.handle(5.0)
    assert got == [("robot.image", bytes(100_000))]
    assert not receiver.handle(0)
    sender.close()
    receiver.close()


def test_a_channel_name_too_long_for_the_group_is_said(group: str) -> None:
    with pytest.raises(BusError, match=r"cannot publish 1 bytes on 'x{64}'"):
        Bus(group).publish("x" * 64, b"1")


@pytest.mark.parametrize("url", ["nothing://", "udpm://300.1.1.1:7667", "udpm://239.1.1.1:port"])
def test_a_url_that_lcm_does_not_know_is_said(url: str) -> None:
    with pytest.raises(BusError):
        Bus(url)


def test_a_missing_multicast_route_is_said_with_the_command_that_makes_one() -> None:
    unshare = shutil.which("unshare")
    if unshare is None or subprocess.run([unshare, "-rn", "true"], capture_output=True, check=False).returncode:
        pytest.skip("this machine gives no network namespace to try it in")
    program = f"from graphnav.core.bus import Bus; Bus({Bus.GROUP!r})"
    done = subprocess.run([unshare, "-rn", sys.executable, "-c", program], capture_output=True, text=True, check=False)
    assert done.stderr.splitlines()[-2:] == [
        "graphnav.core.errors.NoRouteError: no multicast route to 239.255.76.67",
        f"  run as root: {Bus.MAKE_ROUTE}",
    ]


def test_the_command_that_makes_a_route_fixes_it() -> None:
    unshare = shutil.which("unshare")
    program = (
        f"{Bus.MAKE_ROUTE} && '{sys.executable}' -c 'from graphnav.core.bus import *; Bus.require_route(Bus.GROUP)'"
    )
    if unshare is None or subprocess.run([unshare, "-rn", "ip", "link"], capture_output=True, check=False).returncode:
        pytest.skip("this machine gives no network namespace to try it in")
    subprocess.run([unshare, "-rn", "sh", "-c", program], check=True)


def test_a_group_with_a_route_needs_nothing(group: str) -> None:
    Bus.require_route(group)


@pytest.mark.parametrize("host", ["nope", "1.2.3.4", "localhost"])
def test_what_is_no_multicast_address_is_not_taken_for_a_missing_route(host: str) -> None:
    with pytest.raises(BusError, match=f"'{host}' is not a multicast address"):
        Bus.require_route(f"udpm://{host}:7667")


def test_port_0_is_refused(group: str) -> None:
    with pytest.raises(BusError) as caught:
        Bus(f"udpm://{urlsplit(group).hostname}:0")
    assert str(caught.value) == (
        f"port 0 of {urlsplit(group).hostname} is not a port to listen on\n  write {Bus.GROUP}, or another port"
    )


def test_where_lcm_cannot_listen_it_is_said(group: str) -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as taken:
        taken.bind(("", 0))
        bus = Bus(f"udpm://{urlsplit(group).hostname}:{taken.getsockname()[1]}")
        with pytest.raises(BusError) as caught:
            bus.subscribe("x", lambda *_: None)
        bus.close()
    assert str(caught.value) == (
        f"LCM cannot listen on {bus.url}: its port is in use, or LCM's self test of the network failed\n"
        "  choose another port, or run: graphnav doctor"
    )


def test_a_closed_bus_lets_go_of_its_handlers() -> None:
    class Received:
        def take(self, channel: str, data: bytes) -> None: ...

    bus, received = Bus("memq://"), Received()
    bus.subscribe("a", received.take)
    kept = weakref.ref(received)
    bus.close()
    del received
    gc.collect()
    assert kept() is None
