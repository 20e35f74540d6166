"""The page of a multicast group starts before the publishers and survives their restart."""

from __future__ import annotations

import random
import socket
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import pytest

from graphnav.core.bus import Bus
from graphnav.core.codec import encode
from graphnav.core.messages import About

from .drive import about, frame_of
from .served import Page, Served

Serve = Callable[[Path | str], Served]


class Run:
    """A run that publishes when it is told to."""

    def __init__(self, url: str, run_id: str, prefix: str = "") -> None:
        announced = about()
        channels = tuple(prefix + channel for channel in announced.channels)
        self._about = replace(announced, run_id=run_id, channels=channels)
        self._prefix = prefix
        self._bus = Bus(url)
        self._k = 0

    def tick(self) -> None:
        """Publish a frame."""
        self._bus.publish(About.CHANNEL, encode(self._about, 0, self._k))
        for channel, message in frame_of(self._k).items():
            self._bus.publish(self._prefix + channel, encode(message, self._k * 100_000, self._k))
        self._k += 1

    def close(self) -> None:
        self._bus.close()


@pytest.fixture
def page(serve: Serve, group: str) -> Iterator[Page]:
    """Return the page of a group on which nothing was published yet."""
    with Page(serve(group)) as page:
        yield page


def test_a_page_waits_for_a_run_and_survives_its_restart(page: Page, group: str) -> None:
    assert page.update()["state"]["channels"] == []
    page.say(kind="view", channel="control.twist", map=True)
    for run_id in ("first", "second"):
        run = Run(group, run_id)

        def received(known: dict[str, Any], run: Run = run, run_id: str = run_id) -> bool:
            run.tick()
            return bool(
                "graph" in known
                and known["state"]["run_id"] == run_id
                and page.channel("control.twist").get("rate_hz") == pytest.approx(10)
                and known.get("track") is not None
            )

        page.until(received)
        run.close()
    assert page.channel("control.twist")["lost"] == 0


def test_only_the_selected_run_of_two_is_shown(page: Page, group: str) -> None:
    runs, other = {run_id: Run(group, run_id, f"{run_id}.") for run_id in ("left", "right")}, Bus(group)
    for run_id in ("left", "right", "left"):
        page.say(kind="view", run=run_id, channel=f"{run_id}.plane.plane", map=True)

        def received(known: dict[str, Any], run_id: str = run_id) -> bool:
            for run in runs.values():
                run.tick()
            other.publish("CAMERA", encode(frame_of(1)["robot.image"], 0, 0))
            return bool(
                known["state"]["run_id"] == run_id
                and page.channel("CAMERA").get("count")
                and page.channel(f"{run_id}.plane.plane").get("count")
                and known.get("track", {}).get("channel") == f"{run_id}.robot.state"
            )

        page.until(received)
        names = {channel["name"] for channel in page.known["state"]["channels"]}
        assert {name.split(".")[0] for name in names} == {run_id, "graphnav", "CAMERA"}
    for run in runs.values():
        run.close()
    other.close()


def test_packets_that_the_kernel_drops_are_told(page: Page, group: str) -> None:
    run = Run(group, "run")

    def received(_: dict[str, Any]) -> bool:
        run.tick()
        return bool(page.channel("control.twist").get("count"))

    page.until(received)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        sender.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_TTL, 0)
        sender.sendto(b"LC02\0\0\0\1", (urlsplit(group).hostname, urlsplit(group).port))
    page.until(lambda known: bool(known["state"]["dropped_packets"] == 1))
    run.close()


def test_garbage_is_counted_and_the_page_goes_on(page: Page, group: str) -> None:
    run, noise, rng = Run(group, "run"), Bus(group), random.Random(3)
    page.say(kind="view", channel="noise", map=True)

    def received(_known: dict[str, Any]) -> bool:
        run.tick()
        for _ in range(20):
            noise.publish("noise", rng.randbytes(rng.randrange(200)))
            good = bytearray(encode(frame_of(1)["control.twist"], 0, 0))
            good[rng.randrange(len(good))] ^= 255
            noise.publish("noise", bytes(good))
        noisy, image = page.channel("noise"), page.channel("robot.image")
        return bool(noisy and noisy["undecodable"] > 100 and image and image["count"] > 5)

    page.until(received)
    noise.close()
    run.close()
