"""The pages about a robot of one's own: graphs check, adapters turn messages, the driver stops by itself."""

from __future__ import annotations

import json
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import lcm
import numpy as np
import pytest
from graphnav_lcm import twist_t

from graphnav import Image
from graphnav.core.codec import encode

from .conftest import DOCS, blocks, shell, write_files

PAGES = [DOCS / "howto" / name for name in ("robot.md", "adapters.md", "teach.md")]

SENDER = """
import time, lcm
from base import pose_t
bus, pose = lcm.LCM(), pose_t()
end = time.monotonic() + 60
while time.monotonic() < end:
    pose.utime = time.time_ns() // 1000
    pose.pos = [1.5, -2.5]
    bus.publish("POSE", pose.encode())
    time.sleep(0.02)
"""
TRY_ADAPTERS = """
import json
from pathlib import Path
from base import pose_t
from graphnav import Twist
from graphnav.core.catalog import Catalog
from graphnav.core.codec import codec_of
catalog = Catalog()
catalog.add_file(Path("base_adapters.py"))
wheels, pose = catalog.adapters().writers["base.wheels_t"], catalog.adapters().readers["base.pose_t"]
sent = pose_t()
sent.pos, sent.heading_rad, sent.speed_mps = [1.5, -2.5], 0.5, 0.25
odometry = pose.from_lcm(codec_of(pose.lcm_class).decode(sent.encode()))
data = codec_of(wheels.lcm_class).encode(wheels.to_lcm(Twist(v_mps=0.3, omega_radps=1.0), 7))
out = wheels.lcm_class.decode(data)
pose = [odometry.x_m, odometry.y_m, odometry.yaw_rad, odometry.v_mps]
print(json.dumps([*pose, out.left_mps, out.right_mps, out.utime]))
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory, group: str) -> Path:
    """Return a folder that holds the files of the pages, and what their commands make."""
    folder = tmp_path_factory.mktemp("live")
    for page in PAGES:
        write_files(page, folder)
        shell("\n".join(blocks(page, "sh")), folder, group)
    return folder


def test_the_adapters_turn_messages(folder: Path, group: str) -> None:
    (folder / "try_adapters.py").write_text(TRY_ADAPTERS)
    printed = shell("PYTHONPATH=.:${PYTHONPATH:-} python try_adapters.py", folder, group)
    assert json.loads(printed) == pytest.approx([1.5, -2.5, 0.5, 0.25, 0.15, 0.45, 7])


def test_a_run_hears_the_base_of_the_document(folder: Path, group: str) -> None:
    (folder / "sender.py").write_text(SENDER)
    shell(
        "export PYTHONPATH=.:${PYTHONPATH:-}\npython sender.py & sender=$!\n"
        "graphnav run own_base.yaml --until 3 --no-tap --no-pictures -o own\nkill $sender",
        folder,
        group,
    )
    live = json.loads((folder / "own" / "summary.json").read_text())["live"]
    odometry = next(found for found in live["inputs"] if found["name"] == "base.odometry")
    assert odometry["channel"] == "POSE"
    assert odometry["accepted"] > 3
    (wheels,) = live["outputs"]
    assert (wheels["channel"], wheels["motor"]) == ("WHEELS", True)


def test_a_recorded_channel_may_take_the_place_of_the_camera(folder: Path, group: str) -> None:
    (folder / "drive").mkdir()
    image = encode(Image(pixels=np.zeros((12, 16), np.uint8)), 0, 0)
    lcm.EventLog(str(folder / "drive" / "run.lcmlog"), "w", overwrite=True).write_event(0, "camera.image", image)
    shell(
        "graphnav run replay.yaml --until 1 --no-tap --no-pictures -o replayed",
        folder,
        group,
    )
    inputs = json.loads((folder / "replayed" / "summary.json").read_text())["live"]["inputs"]
    assert [found["accepted"] for found in inputs if found["name"] == "camera.image"] == [1]


def test_the_driver_takes_commands_and_stops_by_itself(folder: Path, group: str) -> None:
    bus = lcm.LCM(group)
    command = twist_t()
    command.v_mps, command.omega_radps = 0.25, -0.5
    environment = {"LCM_DEFAULT_URL": group, "PYTHONPATH": ":".join(sys.path)}
    words = [sys.executable, "base_driver.py"]
    with subprocess.Popen(words, cwd=folder, env=environment, stdout=subprocess.PIPE, text=True) as driver:
        try:
            assert driver.stdout is not None
            read = driver.stdout.readline
            until(lambda: bus.publish("BASE_CMD", command.encode()), lambda: read() == "0.25 m/s -0.50 rad/s\n")
            until(lambda: None, lambda: read() == "0.00 m/s 0.00 rad/s\n")
        finally:
            driver.kill()


def until(act: Callable[[], None], is_done: Callable[[], bool]) -> None:
    """Act again and again until something is so; fail after a minute."""
    end_s = time.monotonic() + 60
    while not is_done():
        assert time.monotonic() < end_s
        act()
