"""Live graphs whose inputs and outputs are ROS 2 topics, beside a program of Cyclone DDS."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
import sysconfig
import textwrap
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import cv2
import numpy as np
import pytest

from graphnav import GuardState, Image, Odometry, Recording, Stop, UserError
from graphnav.core.catalog import Catalog
from graphnav.core.dds import Ros2Node
from graphnav.core.graph import resolved_yaml
from graphnav.core.ros2 import DOMAIN, Ros2Network
from graphnav.replay.log.log_graph import graph_to_replay
from graphnav.replay.replay import ReplayOptions, replay

pytest.importorskip("cyclonedds", reason="there is no wheel of Cyclone DDS for this machine")

from testbed.ros_peer import RosPeer, header

if TYPE_CHECKING:
    from tests.live.conftest import Live

    Begin = Callable[..., Live]

GRAPHNAV = Path(sysconfig.get_path("scripts")) / "graphnav"
STAGES = Path(__file__).with_name("stages.py")
SEES = """
ros2: {{domain: {domain}}}
run: {{record: all}}
inputs: {{camera.image: {{ros2: /camera/image_raw, type: sensor_msgs/Image, max_age_s: 5}}}}
stages:
  see: {{use: probe.brightness, in: {{image: camera.image}}}}
outputs: {{see.twist: {{ros2: /cmd_vel, type: {kind}, motor: false}}}}
"""


@pytest.fixture
def domain() -> int:
    """Return a domain that no other process of the tests uses."""
    return 100 + int(os.environ.get("PYTEST_XDIST_WORKER", "gw0").removeprefix("gw"))


@pytest.fixture
def peer(domain: int) -> Iterator[RosPeer]:
    """Return a ROS 2 program."""
    program = RosPeer(domain)
    yield program
    program.close()


def input_of(run: Live, name: str) -> dict[str, Any]:
    """End a run and return what its summary says of an input."""
    summary, _ = run.stop()
    assert summary.outcome == "stopped", summary.failure
    assert summary.live is not None
    found: dict[str, Any] = next(one for one in summary.live["inputs"] if one["name"] == name)
    return found


def test_pictures_come_in_commands_leave_and_the_log_keeps_stamps(live: Begin, peer: RosPeer, domain: int) -> None:
    peer.offer("/camera/image_raw", "sensor_msgs/Image")
    peer.listen("/cmd_vel", "geometry_msgs/TwistStamped")
    run = live(SEES.format(domain=domain, kind="geometry_msgs/TwistStamped"))
    stamps = set[int]()
    peer.wait_for(lambda: len(peer.of("/cmd_vel")) >= 5, lambda: stamps.add(peer.show("/camera/image_raw", 200)))
    summary, log = run.stop()
    assert summary.live is not None
    heard = [one["header"]["stamp"] for one in peer.of("/cmd_vel")]
    assert {one["sec"] * 1_000_000 + one["nanosec"] // 1000 for one in heard} <= stamps
    assert set(log.utimes("camera.image")) <= stamps
    picture = log.message("camera.image", 0)[2]
    assert isinstance(picture, Image)
    pixels = picture.pixels
    assert pixels.shape == (24, 32)
    assert (pixels == 200).all()
    (found,) = summary.live["inputs"]
    assert found["channel"] == "/camera/image_raw"
    assert found["accepted"] >= 5
    assert not found["reasons"]
    catalog = Catalog().add_files([STAGES])
    with Recording(run.folder / "run.lcmlog") as recording:
        assert replay(recording, graph_to_replay(recording, catalog), ReplayOptions()).is_equal


UNDISTORTS = """
ros2: {{domain: {domain}}}
run: {{record: all}}
inputs:
  camera.image: {{ros2: /camera/image_raw, type: sensor_msgs/Image, max_age_s: 5}}
  camera.info:  {{ros2: /camera/camera_info, type: sensor_msgs/CameraInfo, max_age_s: 60}}
stages:
  straight: {{use: io.undistort, in: {{image: camera.image, info: camera.info}}}}
  see:      {{use: probe.brightness, in: {{image: straight.image}}}}
outputs: {{see.twist: {{ros2: /cmd_vel, type: geometry_msgs/Twist, motor: false}}}}
"""


def test_pictures_are_undistorted_by_the_cameras_own_parameters(live: Begin, peer: RosPeer, domain: int) -> None:
    peer.offer("/camera/image_raw", "sensor_msgs/Image")
    peer.offer("/camera/camera_info", "sensor_msgs/CameraInfo")
    peer.listen("/cmd_vel", "geometry_msgs/Twist")
    run = live(UNDISTORTS.format(domain=domain))
    info = {"header": header(1_000_000), "height": 24, "width": 32, "distortion_model": "plumb_bob"}
    info |= {"d": [-0.3, 0.1, 0.0, 0.0, 0.0], "k": [20.0, 0.0, 15.5, 0.0, 20.0, 11.5, 0.0, 0.0, 1.0]}
    info |= {"r": np.eye(3).ravel().tolist(), "p": np.eye(3, 4).ravel().tolist()}

    def show() -> None:
        utime = peer.show("/camera/image_raw", 200)
        peer.say("/camera/camera_info", info | {"header": header(utime)})

    peer.wait_for(lambda: len(peer.of("/cmd_vel")) >= 3, show)
    found = input_of(run, "camera.info")
    assert found["accepted"] >= 1
    assert not found["reasons"]
    with Recording(run.folder / "run.lcmlog") as log:
        straight = log.message("straight.image", -1)[2]
    assert isinstance(straight, Image)
    assert straight.pixels.shape == (24, 32)
    assert (straight.pixels[8:16, 10:20] == 200).all()


def test_what_cannot_be_read_is_counted_by_reason_and_good_pictures_still_count(
    live: Begin, peer: RosPeer, domain: int
) -> None:
    peer.offer("/camera/image_raw", "sensor_msgs/Image")
    peer.listen("/cmd_vel", "geometry_msgs/Twist")
    run = live(SEES.format(domain=domain, kind="geometry_msgs/Twist") + "queues: {see.image: {keep: all}}\n")
    topic = "/camera/image_raw"
    peer.wait_for(lambda: bool(peer.of("/cmd_vel")), lambda: peer.show(topic, 50))
    peer.show(topic, 9, data=[100, 9])
    peer.show(topic, 9, encoding="yuv422")
    peer.show(topic, 9, step=3)
    peer.show(topic, 9, size=(12, 12))
    peer.show(topic, 9, size=(0, 0))
    peer.show(topic, 9, height=2**32 - 1, width=2**32 - 1)
    kind = Catalog().adapters().ros_readers["sensor_msgs/Image"].ros_type
    good = kind.encode({"height": 2, "width": 2, "step": 2, "data": [1] * 4})
    for data in (b"\0\1\0\0", b"\xff" * 40, good[:-4], b"", good + bytes(8)):
        peer.say_bytes(topic, data)  # Cyclone DDS drops all but the last
    seen = len(peer.of("/cmd_vel"))
    peer.wait_for(lambda: len(peer.of("/cmd_vel")) > seen + 3, lambda: peer.show(topic, 200))
    assert max(peer.speeds("/cmd_vel")) > 0
    found = input_of(run, "camera.image")
    reasons = dict(zip(found["reasons"], found["rejected"], strict=True))
    details = " ".join(found["details"])
    assert reasons == {"unreadable": 5, "wrong size": 1, "undecodable": 1}, found
    assert "Traceback" not in details


def test_jpegs_odometry_and_stops_are_read(live: Begin, peer: RosPeer, domain: int) -> None:
    peer.offer("/camera/compressed", "sensor_msgs/CompressedImage")
    peer.offer("/odom", "nav_msgs/Odometry")
    peer.offer("/stop", "std_msgs/Bool")
    run = live(f"""
        ros2: {{domain: {domain}}}
        run: {{record: all}}
        inputs:
          camera.image:  {{ros2: /camera/compressed, type: sensor_msgs/CompressedImage}}
          base.odometry: {{ros2: /odom, type: nav_msgs/msg/Odometry}}
          operator.stop: {{ros2: /stop, type: std_msgs/Bool}}
        stages:
          gather: {{use: probe.gather, in: {{image: camera.image, odometry: base.odometry}}}}
        """)
    jpeg = cv2.imencode(".jpg", np.full((24, 32), 90, np.uint8))[1].reshape(-1).tolist()
    half = {"z": float(np.sin(0.25)), "w": float(np.cos(0.25))}

    def say() -> None:
        head = header(time.time_ns() // 1000)
        pose = {"position": {"x": 1.5, "y": -2.0}, "orientation": half}
        twist = {"linear": {"x": 0.25}, "angular": {"z": -0.5}}
        peer.say("/odom", {"header": head, "pose": {"pose": pose}, "twist": {"twist": twist}})
        peer.say("/camera/compressed", {"header": head, "format": "jpeg", "data": jpeg})
        peer.say("/stop", {"data": True})

    log = run.folder / "run.lcmlog"
    peer.wait_for(lambda: log.exists() and log.stat().st_size > 30_000, say)
    _, recording = run.stop()
    odometry = recording.message("base.odometry", 0)[2]
    assert isinstance(odometry, Odometry)
    assert (odometry.x_m, odometry.y_m, odometry.v_mps, odometry.omega_radps) == (1.5, -2.0, 0.25, -0.5)
    assert odometry.yaw_rad == pytest.approx(0.5)
    picture, stop = recording.message("camera.image", 0)[2], recording.message("operator.stop", 0)[2]
    assert isinstance(picture, Image)
    assert abs(int(picture.pixels.mean()) - 90) <= 1
    assert isinstance(stop, Stop)
    assert stop.engaged
    assert stop.reason == "std_msgs/Bool"


def test_two_publishers_of_a_topic_are_a_fault(live: Begin, peer: RosPeer, domain: int) -> None:
    peer.offer("/camera/image_raw", "sensor_msgs/Image", writers=2)
    run = live(SEES.format(domain=domain, kind="geometry_msgs/Twist"))
    rows = {"height": 24, "width": 32, "encoding": "mono8", "step": 32, "data": [768, 1]}

    def show() -> None:
        for writer in (0, 1):
            peer.say("/camera/image_raw", rows | {"header": header(time.time_ns() // 1000)}, writer)

    def is_told() -> bool:
        return any("second writer" in line for line in run.notices)

    peer.wait_for(is_told, show)
    assert "second writer" in input_of(run, "camera.image")["reasons"]
    assert any("2 writers without sequence numbers: publisher " in line for line in run.notices)


def test_silence_is_explained_by_what_is_published(live: Begin, peer: RosPeer, domain: int) -> None:
    peer.offer("/camera/image_raw", "sensor_msgs/CompressedImage")
    peer.offer("/base/odom", "nav_msgs/Odometry")
    run = live(f"""
        ros2: {{domain: {domain}}}
        inputs:
          camera.image:   {{ros2: /camera/image_raw, type: sensor_msgs/Image}}
          base.odometry:  {{ros2: /odom, type: nav_msgs/Odometry}}
          operator.twist: {{ros2: /joy_vel, type: geometry_msgs/Twist}}
        stages:
          gather: {{use: probe.gather, in: {{image: camera.image, odometry: base.odometry}}}}
          both:   {{use: probe.both, in: {{a: operator.twist, b: operator.twist}}}}
        outputs: {{both.twist: {{ros2: /cmd_vel, type: geometry_msgs/Twist, motor: false}}}}
        """)

    def told(text: str) -> bool:
        return any(text in line for line in run.notices)

    expected = (
        "its publisher has the type sensor_msgs/CompressedImage, not sensor_msgs/Image",
        "nav_msgs/Odometry is published on /base/odom",
        f"no program publishes it in domain {domain} through lo (programs of this machine alone): is it another",
        f"not heard: no program subscribes /cmd_vel in domain {domain} through lo",
    )
    peer.wait_for(lambda: all(map(told, expected)))
    run.stop()


def test_a_run_that_is_killed_is_followed_by_stops_and_then_by_nothing(
    tmp_path: Path, group: str, peer: RosPeer, domain: int
) -> None:
    shutil.copy(STAGES, tmp_path)
    graph = tmp_path / "graph.yaml"
    graph.write_text(
        textwrap.dedent(f"""
        plugins: [stages.py]
        ros2: {{domain: {domain}}}
        inputs: {{camera.image: {{ros2: /camera/image_raw, type: sensor_msgs/Image}}}}
        stages:
          see:   {{use: probe.brightness, in: {{image: camera.image}}}}
          guard: {{use: probe.pass, every_ms: 20, in: {{command: see.twist, image: camera.image}}}}
        outputs: {{guard.twist: {{ros2: /cmd_vel, type: geometry_msgs/Twist, motor: true, max_age_s: 0.5}}}}
        """)
    )
    peer.offer("/camera/image_raw", "sensor_msgs/Image")
    peer.listen("/cmd_vel", "geometry_msgs/Twist")
    words = ["run", str(graph), "--url", group, "--no-tap", "--no-pictures", "-o", str(tmp_path / "run")]
    with (tmp_path / "output.txt").open("wb") as output:
        run = subprocess.Popen([str(GRAPHNAV), *words], stdout=output, stderr=subprocess.STDOUT)
    try:
        peer.wait_for(lambda: any(v > 0 for v in peer.speeds("/cmd_vel")), lambda: peer.show("/camera/image_raw", 100))
    finally:
        run.send_signal(signal.SIGKILL)
        run.wait()
    killed_s = time.monotonic()
    peer.wait_for(lambda: peer.heard[-1][2] < time.monotonic() - 0.5)
    after = [fields["linear"]["x"] for _, fields, at_s in peer.heard if at_s > killed_s + 0.1]
    assert len(after) >= 20
    assert not any(after), after
    assert peer.heard[-1][2] > killed_s + 0.5


GUARDED = """
ros2: {{domain: {domain}}}
inputs: {{camera.image: {{ros2: /camera/image_raw, type: sensor_msgs/Image, max_age_s: 0.5}}}}
stages:
  see:   {{use: probe.brightness, in: {{image: camera.image}}}}
  guard:
    use: control.guard
    every_ms: 20
    in: {{command: see.twist, image: camera.image}}
outputs: {{guard.twist: {{ros2: /cmd_vel, type: geometry_msgs/Twist, motor: true}}}}
"""


def test_the_base_stops_when_the_program_of_the_camera_dies(live: Begin, peer: RosPeer, domain: int) -> None:
    camera = RosPeer(domain)
    camera.offer("/camera/image_raw", "sensor_msgs/Image")
    peer.listen("/cmd_vel", "geometry_msgs/Twist")
    run = live(GUARDED.format(domain=domain))
    pixels = np.random.default_rng(0).integers(0, 256, 24 * 32).tolist()
    peer.wait_for(
        lambda: any(speed > 0 for speed in peer.speeds("/cmd_vel")),
        lambda: camera.show("/camera/image_raw", 0, data=pixels),
    )
    os.kill(camera.pid, signal.SIGKILL)
    camera.close()
    peer.wait_for(lambda: len(peer.speeds("/cmd_vel")) > 60 and not any(peer.speeds("/cmd_vel")[-20:]))
    summary, log = run.stop()
    assert summary.outcome == "stopped", summary.failure
    told = log.message("guard.state", -1)[2]
    assert isinstance(told, GuardState)
    assert set(told.causes) == {"stale"}


def test_a_map_is_latched(peer: RosPeer, domain: int) -> None:
    adapter = Catalog().adapters().ros_writers["nav_msgs/OccupancyGrid"]
    node = Ros2Node(Ros2Network(domain), "a test")
    try:
        node.offer("/map", adapter.ros_type, latched=adapter.latched)
        node.publish("/map", adapter.ros_type.encode({"info": {"width": 2, "height": 1}, "data": [-1, 100]}))
        peer.listen("/map", "nav_msgs/OccupancyGrid", latched=True)
        peer.wait_for(lambda: bool(peer.of("/map")))
        assert peer.of("/map")[0]["data"] == [255, 100]  # an octet is not signed
    finally:
        node.close()


def test_what_is_missing_is_told_where_the_graph_asks_for_it(
    live: Begin, domain: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    graph = SEES.format(domain=domain, kind="geometry_msgs/Twist")
    with pytest.raises(UserError, match=r"(?s)graph.yaml:4:10: there is no network interface 'wlan9'.*interfaces are"):
        live(graph.replace(f"domain: {domain}", "interface: wlan9"), "first").stop()
    monkeypatch.setenv(DOMAIN, "lab")
    with pytest.raises(UserError, match=r"ROS_DOMAIN_ID is 'lab', expected a number from 0 to 232"):
        live(graph.replace(f"ros2: {{domain: {domain}}}\n", ""), "second").stop()
    monkeypatch.setitem(sys.modules, "cyclonedds", None)
    needs = r"(?s)graph.yaml:4:10: the input 'camera.image' with ros2 needs cyclonedds.*pip install .cyclonedds"
    with pytest.raises(UserError, match=needs):
        live(graph, "third").stop()


def test_a_graph_loads_again(load: Callable[[str], Any], domain: int) -> None:
    graph = load(SEES.format(domain=domain, kind="geometry_msgs/Twist"))
    text = resolved_yaml(load(resolved_yaml(graph)))
    assert f"ros2: {{domain: {domain}, interface: lo}}" in text
    assert resolved_yaml(load(text)) == text
