"""A multicast group, served to a client of Foxglove's protocol: it waits for publishers and survives their restart."""

from __future__ import annotations

import random
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from graphnav.core.bus import Bus
from graphnav.core.codec import encode
from graphnav.core.messages import About, Image, Message, Odometry

from .drive import about, frame_of, world
from .foxglove_client import FoxgloveClient, FoxgloveServed, Shown

Serve = Callable[[Path | str], FoxgloveServed]


class Run:
    """A run that publishes a frame whenever it is told to; what it announces and adds may be chosen."""

    def __init__(self, url: str, run_id: str, announced: About | None = None) -> None:
        self._about = replace(announced or about(), run_id=run_id)
        self._bus = Bus(url)
        self.more: dict[str, Message] = {}
        self.k = 0

    def tick(self) -> None:
        """Publish a frame."""
        self._bus.publish(About.CHANNEL, encode(self._about, 0, self.k))
        for channel, message in (frame_of(self.k) | self.more).items():
            self._bus.publish(channel, encode(message, self.k * 100_000, self.k))
        self.k += 1

    def publish(self, channel: str, data: bytes) -> None:
        self._bus.publish(channel, data)

    def close(self) -> None:
        self._bus.close()


@pytest.fixture
def client(serve_foxglove: Serve, group: str) -> Iterator[FoxgloveClient]:
    """Return a client of a group on which nothing was published yet."""
    with FoxgloveClient(serve_foxglove(group).url) as client:
        yield client


def headings(client: FoxgloveClient) -> list[Shown]:
    """Return the lines of text that tell of a run."""
    return [shown for shown in client.of("/log") if "(seed 7)" in shown.message.message]


def announcing(*channels: tuple[str, str]) -> About:
    return replace(about(), channels=tuple(c for c, _ in channels), types=tuple(t for _, t in channels))


def test_a_client_waits_for_a_run_and_survives_its_restart(client: FoxgloveClient, group: str) -> None:
    client.subscribe("/log")
    client.until(lambda: "/log" in client.offered)
    assert client.info["capabilities"] == []
    assert "/control/twist" not in client.offered
    before_ns = time.time_ns()
    for run_id in ("first", "second"):
        run = Run(group, run_id)
        n_headings, n_twists = len(headings(client)), len(client.of("/control/twist"))
        client.until(lambda: len(headings(client)) > n_headings, run.tick)  # noqa: B023 - called at once
        if not n_twists:
            client.subscribe("/control/twist")
        client.until(lambda: len(client.of("/control/twist")) >= n_twists + 5, run.tick)  # noqa: B023 - as above
        run.close()
    twists = client.of("/control/twist")
    assert [shown.time_ns for shown in twists] == sorted(shown.time_ns for shown in twists)
    assert before_ns - 10**9 < twists[0].time_ns < twists[-1].time_ns < time.time_ns() + 10**9


def test_a_new_runs_channels_replace_the_old_ones(client: FoxgloveClient, group: str) -> None:
    old, new = Run(group, "old"), Run(group, "new")
    old._about = replace(announcing(("extra", "graphnav_lcm.twist_t"), ("gone", "graphnav_lcm.twist_t")), run_id="old")
    new._about = replace(announcing(("extra", "graphnav_lcm.odometry_t")), run_id="new")
    client.until(lambda: {"/extra", "/gone"} <= client.offered.keys(), old.tick)
    assert client.offered["/extra"]["schemaName"] == "graphnav_lcm.twist_t"
    new.more = {"extra": Odometry(1.0, 2.0, 0.0, 0.0, 0.0)}
    client.until(lambda: "/gone" not in client.offered, new.tick)
    client.until(lambda: client.offered.get("/extra", {}).get("schemaName") == "graphnav_lcm.odometry_t")
    client.subscribe("/extra")
    client.until(lambda: client.of("/extra"), new.tick)
    assert client.of("/extra")[-1].message["y_m"] == 2.0
    old.close()
    new.close()


def test_the_map_the_robot_and_its_path(client: FoxgloveClient, group: str) -> None:
    topics = ("/scene/map", "/scene/robot", "/scene/path", "/scene/pose", "/tf")
    client.subscribe(*topics)
    run = Run(group, "run")
    room = encode(world(), 0, 0)

    def tick() -> None:
        run.publish("robot.map", room)
        run.tick()

    client.until(lambda: all(client.of(topic) for topic in topics), tick)
    client.until(lambda: len(client.of("/scene/path")) > 1, tick)
    n_maps = len(client.of("/scene/map"))  # two, if the first one arrives while the client subscribes
    client.until(lambda: len(client.of("/scene/path")) > 3, tick)
    assert len(client.of("/scene/map")) == n_maps, "a map that is repeated is shown once"
    update = client.of("/scene/map")[0].message
    assert (len(update.deletions), len(update.entities)) == (1, 4)
    run.close()


def test_only_what_is_subscribed_to_is_decoded(
    client: FoxgloveClient, group: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    from graphnav.core.codec.compiled import Codec

    decoded: set[str] = set()
    decode = Codec.decode

    def noting(self: Codec, data: bytes) -> dict[str, object]:
        values = decode(self, data)
        decoded.add(
            "image"
            if {"rows", "cols", "channels"} <= values.keys()
            else "twist"
            if "omega_radps" in values
            else str(sorted(values))
        )
        return values

    monkeypatch.setattr(Codec, "decode", noting)
    run = Run(group, "run")
    client.until(lambda: "/control/twist" in client.offered, run.tick)
    decoded.clear()
    client.subscribe("/control/twist")
    client.until(lambda: len(client.of("/control/twist")) > 5, run.tick)
    assert decoded == {"twist"}
    client.unsubscribe("/control/twist")
    client.subscribe("/robot/image/picture")
    client.until(lambda: client.of("/robot/image/picture"), run.tick)
    assert decoded == {"twist", "image"}
    run.close()


def test_garbage_is_counted_and_told(client: FoxgloveClient, group: str) -> None:
    run, rng = Run(group, "run"), random.Random(3)
    client.subscribe("/log")

    def publish() -> None:
        run.tick()
        run.publish("\x1b[31mflow", encode(frame_of(1)["flow.flow"], 0, 0))
        for _ in range(20):
            run.publish("noise", rng.randbytes(rng.randrange(200)))
            good = bytearray(encode(frame_of(1)["flow.flow"], 0, 0))
            good[rng.randrange(8, len(good))] ^= 255
            run.publish("\x1b[31mflow", bytes(good[: rng.randrange(8, len(good))]))

    def told(what: str) -> bool:
        return any(what in shown.message.message for shown in client.of("/log"))

    unknown, short = "channel 'noise': its type is not installed", r"channel '\x1b[31mflow': messages that cannot"
    client.until(lambda: told(unknown) and told(short), publish)
    client.subscribe("/control/twist", r"/\x1b[31mflow", r"/\x1b[31mflow/picture")
    client.until(lambda: len(client.of("/control/twist")) > 5, publish)
    run.close()


def test_names_from_any_client_are_bounded(client: FoxgloveClient, group: str) -> None:
    client.subscribe("/log")
    run = Run(group, "run")
    twist = encode(frame_of(1)["control.twist"], 0, 0)

    def publish() -> None:
        run.tick()
        for number in range(run.k * 50, run.k * 50 + 50):
            run.publish(f"name{number}", twist)

    client.until(
        lambda: any("messages of further channels" in shown.message.message for shown in client.of("/log")), publish
    )
    assert len(client.offered) <= 2 * 240 + 6
    later = Run(group, "later", announcing(("later.twist", "graphnav_lcm.twist_t")))
    client.until(lambda: "/later/twist" in client.offered, later.tick)
    later.close()
    run.close()


def test_a_client_that_does_not_read_holds_up_no_other(serve_foxglove: Serve, group: str) -> None:
    url = serve_foxglove(group).url
    run = Run(group, "run")
    run.more = {"big": Image(np.random.default_rng(1).integers(0, 255, (200, 200), np.uint8))}
    with FoxgloveClient(url) as slow, FoxgloveClient(url) as quick:
        slow.until(lambda: "/big/picture" in slow.offered, run.tick)
        quick.until(lambda: "/big/picture" in quick.offered, run.tick)
        slow.subscribe("/big/picture")
        quick.subscribe("/big/picture")
        quick.until(lambda: len(quick.of("/big/picture")) > 50, run.tick)
    run.close()
