"""The example of a camera driver, a graph and the driver of the wheels: its commands run, the wheels turn and stop."""

from __future__ import annotations

import json
import re
import shutil
from pathlib import Path

import pytest

from .conftest import DOCS, blocks, shell

EXAMPLE = DOCS / "examples" / "camera_driver"
MAKE, FILM, RUN = blocks(EXAMPLE / "README.md", "sh")


@pytest.fixture(scope="module")
def example(tmp_path_factory: pytest.TempPathFactory, group: str) -> Path:
    """Return a copy of the example with its programs made and frames to play; skip where there is no C compiler."""
    for program in ("cc", "make"):
        if shutil.which(program) is None:
            pytest.skip(f"there is no {program}")
    ignored = shutil.ignore_patterns(*(EXAMPLE / ".gitignore").read_text().replace("/", "").split())
    folder = Path(shutil.copytree(EXAMPLE, tmp_path_factory.mktemp("docs") / "example", ignore=ignored))
    shell(MAKE + FILM, folder, group)
    return folder


@pytest.mark.long
def test_the_commands_drive_the_wheels_and_stop_them(example: Path, group: str) -> None:
    shell(RUN, example, group)
    lines = (example / "wheels.txt").read_text().splitlines()[1:]
    is_turning = [any(float(speed) for speed in re.findall(r"[-+] *[\d.]+(?= rad/s)", line)) for line in lines]
    assert lines[0].endswith("no command")
    assert any(is_turning)
    after = lines[len(lines) - is_turning[::-1].index(True) :]
    assert after[0].endswith("rad/s"), "the first zeros behind the last command are a stop that was sent"
    assert after[-1].endswith("no command"), "then nothing comes, and the driver's own timeout holds"


@pytest.mark.long
def test_the_driver_plays_a_video_at_its_rate(example: Path, group: str) -> None:
    (example / "make_video.py").write_text(
        "import cv2, glob\n"
        "frames = [cv2.imread(name) for name in sorted(glob.glob('frames/*.jpg'))]\n"
        "video = cv2.VideoWriter('video.avi', cv2.VideoWriter_fourcc(*'MJPG'), 15, frames[0].shape[1::-1])\n"
        "for frame in frames: video.write(frame)\n"
        "video.release()\n"
    )
    (example / "front.yaml").write_text(
        (example / "graph.yaml").read_text().replace("channel: CAMERA", "channel: FRONT")
    )
    script = (
        "python make_video.py\n"
        "python driver.py video.avi --channel FRONT > driver.txt & driver=$!\n"
        "graphnav run front.yaml --until 3 --no-tap --no-pictures -o front\n"
        "kill $driver\n"
    )
    shell(script, example, group)
    assert " on FRONT at 15 Hz" in (example / "driver.txt").read_text()
    (camera,) = json.loads((example / "front" / "summary.json").read_text())["live"]["inputs"]
    assert camera["channel"] == "FRONT"
    assert camera["accepted"] > 3
    assert camera["rejected"] == []


@pytest.mark.long
def test_a_camera_in_c_with_a_zeroed_struct_is_used(example: Path, group: str) -> None:
    graph = (example / "graph.yaml").read_text()
    (example / "in_c.yaml").write_text(graph.replace("bot_core.image_t", "graphnav_lcm.image_t"))
    (example / "raw.py").write_text(
        "import cv2, glob, sys, time\n"
        "for name in sorted(glob.glob('frames/*.jpg')):\n"
        "    sys.stdout.buffer.write(cv2.imread(name, cv2.IMREAD_GRAYSCALE).tobytes())\n"
        "    sys.stdout.buffer.flush()\n"
        "    time.sleep(0.1)\n"
    )
    script = (
        "python raw.py | ./camera 160 120 &\ngraphnav run in_c.yaml --until 4 --no-tap --no-pictures -o in_c\nwait\n"
    )
    shell(script, example, group)
    summary = json.loads((example / "in_c" / "summary.json").read_text())
    (camera,) = summary["live"]["inputs"]
    assert camera["accepted"] > 3
    assert camera["rejected"] == []


@pytest.mark.long
def test_a_camera_of_graphnav_takes_the_place_of_the_driver(example: Path, group: str) -> None:
    script = (
        "graphnav run camera.yaml --set camera.device=frames --no-tap --no-pictures -o sent & sent=$!\n"
        "graphnav run graph.yaml --until 3 --no-tap --no-pictures -o taken\n"
        "kill -INT $sent\nwait\n"
    )
    shell(script, example, group)
    (camera,) = json.loads((example / "taken" / "summary.json").read_text())["live"]["inputs"]
    assert camera["accepted"] > 3
    assert camera["rejected"] == []
