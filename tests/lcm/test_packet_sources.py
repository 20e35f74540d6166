"""The programs that send on a channel are known by the source addresses of their packets."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Collection, Iterator

import lcm
import pytest

from graphnav.core.bus import Bus
from graphnav.live.inputs import packet_sources
from graphnav.live.inputs.packet_sources import PacketSources


@pytest.fixture
def sources(group: str) -> Iterator[PacketSources]:
    found = PacketSources(Bus.with_defaults(group), ["CAMERA", "ODOMETRY"])
    yield found
    found.close()


def wait_for(holds: Callable[[], bool]) -> None:
    end_s = time.monotonic() + 20.0
    while not holds():
        assert time.monotonic() < end_s
        time.sleep(0.005)


def test_each_program_that_sends_is_one_writer(sources: PacketSources, group: str) -> None:
    first, second = lcm.LCM(group), lcm.LCM(group)
    begin_s = time.monotonic()
    first.publish("CAMERA", b"small")
    wait_for(lambda: len(sources.writers("CAMERA", begin_s)) == 1)
    second.publish("CAMERA", b"small")
    wait_for(lambda: len(sources.writers("CAMERA", begin_s)) == 2)
    assert all(f" (pid {os.getpid()}, " in name for name in sources.writers("CAMERA", begin_s))
    assert not sources.writers("ODOMETRY", begin_s)
    assert not sources.writers("CAMERA", time.monotonic())


def test_large_messages_of_another_socket_are_not_another_writer(sources: PacketSources, group: str) -> None:
    small, large = lcm.LCM(group), lcm.LCM(group)
    begin_s = time.monotonic()
    for _ in range(2):
        small.publish("CAMERA", b"small")
        large.publish("CAMERA", bytes(200_000))
    large.publish("ODOMETRY", bytes(200_000))
    wait_for(lambda: bool(sources.writers("ODOMETRY", begin_s)))
    assert len(sources.writers("CAMERA", begin_s)) == 1


def test_other_channels_are_not_seen(sources: PacketSources, group: str) -> None:
    sender = lcm.LCM(group)
    begin_s = time.monotonic()
    for channel in ("CAMERA2", "CAM", "CAMER", "OTHER"):
        sender.publish(channel, b"CAMERA\0" * 20)
        sender.publish(channel, b"CAMERA\0" * 20_000)
    sender.publish("ODOMETRY", b"")
    wait_for(lambda: bool(sources.writers("ODOMETRY", begin_s)))
    assert not sources.writers("CAMERA", begin_s)


def test_the_sources_of_a_channel_are_bounded(sources: PacketSources, group: str) -> None:
    senders = [lcm.LCM(group) for _ in range(40)]
    begin_s = time.monotonic()
    for sender in senders:
        sender.publish("CAMERA", b"")
    senders[-1].publish("ODOMETRY", b"")
    wait_for(lambda: bool(sources.writers("ODOMETRY", begin_s)))
    assert len(sources.writers("CAMERA", begin_s)) == 16


def test_a_message_from_a_new_address_does_not_cost_a_search_each_time(
    sources: PacketSources, group: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    searched: list[Collection[tuple[str, int]]] = []
    search = packet_sources._processes_of

    def counted(addresses: Collection[tuple[str, int]]) -> dict[tuple[str, int], str]:
        searched.append(addresses)
        return search(addresses)

    monkeypatch.setattr(packet_sources, "_processes_of", counted)
    begin_s = time.monotonic()
    for _ in range(30):
        lcm.LCM(group).publish("CAMERA", b"")
    lcm.LCM(group).publish("ODOMETRY", b"")
    wait_for(lambda: bool(sources.writers("ODOMETRY", begin_s)))
    assert len(sources.writers("CAMERA", begin_s)) == 16
    assert 0 < len(searched) <= 1 + (time.monotonic() - begin_s) / 0.25
