"""A log, served to a client of Foxglove's protocol."""

from __future__ import annotations

import io
import math
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from PIL import Image as Pillow

from graphnav.core.codec import encode
from graphnav.core.messages import Image, Stop, Twist
from graphnav.core.record import LogWriter

from .drive import MARKUP, N_FRAMES, PERIOD_US, frame_of
from .foxglove_client import FoxgloveClient, FoxgloveServed

Serve = Callable[[Path | str], FoxgloveServed]
END_NS = (N_FRAMES - 1) * PERIOD_US * 1000


@pytest.fixture
def client(log: Path, serve_foxglove: Serve) -> Iterator[FoxgloveClient]:
    with FoxgloveClient(serve_foxglove(log).url) as client:
        yield client


def test_the_client_is_told_what_the_log_holds(client: FoxgloveClient) -> None:
    assert client.info["dataStartTime"] == {"sec": 0, "nsec": 0}
    assert client.info["dataEndTime"] == {"sec": END_NS // 10**9, "nsec": END_NS % 10**9}
    assert set(client.info["capabilities"]) == {"time", "playbackControl"}
    client.until(lambda: "/log" in client.offered and "/control/twist" in client.offered)
    schemas = {topic: channel["schemaName"] for topic, channel in client.offered.items()}
    assert schemas["/robot/image/picture"] == schemas["/plane/plane/picture"] == "foxglove.CompressedImage"
    assert schemas["/scene/map"] == schemas["/scene/path"] == schemas["/scene/robot"] == "foxglove.SceneUpdate"
    assert schemas["/scene/pose"] == "foxglove.PoseInFrame"
    assert schemas["/tf"] == "foxglove.FrameTransform"
    assert schemas["/log"] == "foxglove.Log"
    assert schemas["/control/twist"] == "graphnav_lcm.twist_t"


def test_every_message_comes_with_its_time_in_the_log(client: FoxgloveClient) -> None:
    client.subscribe("/control/twist")
    client.until(lambda: client.of("/control/twist"))
    client.control(play=True, speed=20.0, seek_ns=0)
    client.until(lambda: client.state is not None and client.state.status == "ended")
    client.until(lambda: client.of("/control/twist")[-1].time_ns == END_NS)
    last = client.of("/control/twist")[-N_FRAMES:]
    assert [shown.time_ns for shown in last] == [k * PERIOD_US * 1000 for k in range(N_FRAMES)]
    for k, shown in enumerate(last):
        assert (shown.message["utime"], shown.message["seq"]) == (k * PERIOD_US, k)
        assert shown.message["omega_radps"] == pytest.approx(0.1 * math.sin(0.02 * k))


def test_pause_seek_and_speed(client: FoxgloveClient) -> None:
    client.subscribe("/robot/state")
    client.until(lambda: client.of("/robot/state"))
    state = client.control(play=False, seek_ns=1_950_000_000, request="seek")
    assert state == ("paused", 1_950_000_000, 1.0, True, "seek")
    client.until(lambda: client.of("/robot/state")[-1].time_ns == 1_900_000_000)
    client.until(lambda: client.time_ns == 1_950_000_000)
    state = client.control(play=False, speed=2.5, request="speed")
    assert state == ("paused", 1_950_000_000, 2.5, False, "speed")
    state = client.control(play=False, seek_ns=2**64 - 1, request="far")
    assert (state.time_ns, state.did_seek) == (END_NS, True)
    for number, speed in enumerate((math.nan, math.inf, -1.0, 0.0)):
        assert client.control(play=False, speed=speed, seek_ns=0, request=f"n{number}").speed == 1.0
    assert client.control(play=False, speed=1e30, request="fast").speed == 100.0
    client.control(play=True, speed=50.0, request="play")
    client.until(lambda: client.of("/robot/state")[-1].time_ns == END_NS)
    client.until(lambda: client.state is not None and client.state.status == "ended")
    assert client.control(play=True, request="again").time_ns < END_NS


def test_the_log_waits_for_the_first_client(client: FoxgloveClient) -> None:
    client.until(lambda: client.time_ns == 0)
    client.subscribe("/control/twist")
    client.until(lambda: client.state is not None and client.state.status == "playing")
    client.until(lambda: client.of("/control/twist"))
    assert client.of("/control/twist")[0].time_ns == 0


def test_pictures_are_the_images_pixel_by_pixel(client: FoxgloveClient) -> None:
    client.control(play=False)
    client.subscribe("/robot/image/picture")
    for k in (0, 7, 31):
        client.control(play=False, seek_ns=k * PERIOD_US * 1000, request=f"to {k}")
        client.until(lambda: client.shown and client.shown[-1].time_ns == k * PERIOD_US * 1000)  # noqa: B023 - at once
        image = frame_of(k)["robot.image"]
        assert isinstance(image, Image)
        picture = client.shown[-1].message
        assert picture.format == "png"
        assert np.array_equal(np.asarray(Pillow.open(io.BytesIO(picture.data))), image.pixels)


def test_flow_and_plane_are_drawn(client: FoxgloveClient) -> None:
    client.control(play=False, seek_ns=10**9)
    client.subscribe("/flow/flow/picture", "/plane/plane/picture")
    client.until(lambda: client.of("/flow/flow/picture") and client.of("/plane/plane/picture"))
    for shown in client.shown:
        picture = np.asarray(Pillow.open(io.BytesIO(shown.message.data))).astype(int)
        assert picture.shape == (12, 16, 3)
        assert picture.std() > 5


def test_the_robot_and_its_path_on_the_map(client: FoxgloveClient) -> None:
    client.control(play=False, seek_ns=2 * 10**9)
    client.subscribe("/scene/map", "/scene/robot", "/scene/path", "/scene/pose", "/tf")
    topics = ("/scene/map", "/scene/robot", "/scene/path", "/scene/pose", "/tf")
    client.until(lambda: all(client.of(topic) for topic in topics))
    assert len(client.of("/scene/map")[-1].message.entities) == 4
    assert len(client.of("/scene/path")[-1].message.entities[0].lines[0].points) == 21
    assert client.of("/scene/pose")[-1].message.pose.position.x == pytest.approx(2.0)
    assert client.of("/tf")[-1].message.translation.x == pytest.approx(2.0)
    client.control(play=False, seek_ns=10**9, request="back")
    client.until(lambda: len(client.of("/scene/path")[-1].message.entities[0].lines[0].points) == 11)


def test_what_clients_subscribed_to_is_what_they_get(client: FoxgloveClient) -> None:
    client.subscribe("/steer/steering", "/log")
    client.until(lambda: client.state is not None and client.state.status == "playing")
    client.control(play=True, speed=20.0)
    client.until(lambda: client.state is not None and client.state.status == "ended")
    assert {shown.topic for shown in client.shown} <= {"/steer/steering", "/log"}


def test_hostile_names_and_strings_are_shown_as_text(client: FoxgloveClient) -> None:
    client.control(play=False)
    client.subscribe("/log", "/" + MARKUP)
    client.control(play=True, speed=20.0, seek_ns=0)
    client.until(lambda: client.state is not None and client.state.status == "ended")
    client.until(lambda: any("alert(2)" in shown.message.message for shown in client.of("/log")))
    lines = [shown.message for shown in client.of("/log")]
    assert all(line.message.isprintable() and line.name.isprintable() for line in lines)
    assert client.of("/" + MARKUP)[-1].message["reason"] == "<script>alert(2)</script>\x1b[31m"


def test_a_client_that_comes_late_gets_the_newest(log: Path, serve_foxglove: Serve) -> None:
    url = serve_foxglove(log).url
    with FoxgloveClient(url) as early:
        early.control(play=False, seek_ns=10**9)
        with FoxgloveClient(url) as late:
            late.subscribe("/control/twist", "/scene/map", "/log")
            late.until(lambda: late.of("/scene/map"))
            late.until(lambda: [shown.time_ns for shown in late.of("/control/twist")][-1:] == [10**9])
            late.until(lambda: late.of("/log"))
            assert late.of("/log")[0].time_ns == 10**9


def test_a_log_that_is_cut_is_shown_to_its_end(log: Path, serve_foxglove: Serve) -> None:
    log.write_bytes(log.read_bytes()[:-40])
    with FoxgloveClient(serve_foxglove(log).url) as client:
        client.subscribe("/log", "/flow/flow")
        client.until(lambda: any("is truncated" in shown.message.message for shown in client.of("/log")))
        client.control(play=False, seek_ns=END_NS)
        client.until(lambda: client.of("/flow/flow") and client.of("/flow/flow")[-1].time_ns == END_NS)


def test_what_cannot_be_decoded_is_counted_and_told(tmp_path: Path, serve_foxglove: Serve) -> None:
    twist = encode(Twist(0.1, 0.2), 0, 0)
    with LogWriter(tmp_path / "log") as log:
        log.write("OK", 0, twist)
        log.write("\x1b[31mBAD", 0, twist[:-3])
        log.write("OTHER", 0, b"\x01\x02\x03\x04\x05\x06\x07\x08 something else")
        log.write("STOP", 1, encode(Stop(True, "a\ud7ffb"), 1, 0))
    with FoxgloveClient(serve_foxglove(tmp_path / "log").url) as client:
        client.control(play=False, seek_ns=10**9)
        client.subscribe("/log", "/OK")
        client.until(lambda: client.of("/OK"))
        told = {
            r"channel '\x1b[31mBAD': messages that cannot be decoded: 1",
            "channel 'OTHER': its type is not installed, messages not shown: 1",
        }
        client.until(lambda: told <= {shown.message.message for shown in client.of("/log")})


@pytest.mark.parametrize("utime", [-(2**63), -1, 2**63 - 1, 2**32 * 10**6])
def test_a_log_of_any_stamps_is_shown(tmp_path: Path, serve_foxglove: Serve, utime: int) -> None:
    with LogWriter(tmp_path / "log") as log:
        log.write("A", utime, encode(Twist(0.1, 0.2), 0, 0))
        log.write("B", 5, encode(Twist(0.1, 0.2), 0, 0))
        log.write("C", utime, encode(Twist(0.1, 0.2), 0, 0))
    with FoxgloveClient(serve_foxglove(tmp_path / "log").url) as client:
        client.subscribe("/A", "/B", "/C")
        client.until(lambda: client.of("/A") and client.of("/B") and client.of("/C"))


def test_any_page_may_connect_as_foxgloves_own_has_to(log: Path, serve_foxglove: Serve) -> None:
    with FoxgloveClient(serve_foxglove(log).url, origin="https://app.foxglove.dev") as client:
        client.until(lambda: "/log" in client.offered)


def test_requests_that_are_none_are_survived(log: Path, serve_foxglove: Serve) -> None:
    url = serve_foxglove(log).url
    for said in (
        "",
        "{",
        '{"op":"subscribe","subscriptions":[{"id":1,"channelId":99999}]}',
        b"",
        b"\x03",
        b"\xff" * 99,
    ):
        with FoxgloveClient(url) as hostile:
            hostile.socket.send(said)
    with FoxgloveClient(url) as client:
        client.subscribe("/control/twist")
        client.until(lambda: client.of("/control/twist"))


def test_the_outcome_is_told_at_the_end(client: FoxgloveClient, log: Path) -> None:
    (log.parent / "summary.json").write_text('{"outcome": "goal", "notices": ["a notice"]}')
    client.subscribe("/log")
    client.control(play=True, speed=50.0, seek_ns=0)
    client.until(lambda: any(shown.message.message == "outcome: goal" for shown in client.of("/log")))
    assert client.of("/log")[-1].time_ns == END_NS
