"""Mistakes of a driver, each made live against a graph: what the run prints of it."""

from __future__ import annotations

import json
import math
import subprocess
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import cv2
import graphnav_lcm
import lcm
import numpy as np
import pytest
from graphnav_adapters.bot_core_image import MJPEG, BotCoreImage
from testbed.processes import graphnav_run, group_url, running

from graphnav.core.codec import codec_of
from tests.targets import Targets

GRAPH = """\
inputs:
  camera.image: {{channel: CAMERA, type: {type}, max_age_s: 0.5}}
  base.odometry: {{channel: ODOMETRY, type: graphnav_lcm.odometry_t}}
stages:
  flow: {{use: flow.lucas_kanade, in: {{image: camera.image}}}}
  motion: {{use: odometry.motion, in: {{flow: flow.flow, odometry: base.odometry}}}}
"""
NUMBER = 211
RUN_S, PATIENCE_S, PERIOD_S = 12.0, 60.0, 0.1
IMAGE, BOT_CORE = codec_of(graphnav_lcm.image_t), codec_of(BotCoreImage.lcm_class)
ODOMETRY, TWIST = codec_of(graphnav_lcm.odometry_t), codec_of(graphnav_lcm.twist_t)
ROWS, COLS = 120, 160
FLOOR = np.kron(np.random.default_rng(0).integers(40, 200, (30, 40)), np.ones((4, 4))).astype(np.uint8)
JPEG: bytes = cv2.imencode(".jpg", FLOOR)[1].tobytes()
Message = tuple[str, bytes]


class Mistake(NamedTuple):
    """A mistake: what is sent at every period by each of some programs, and part of the line that has to be printed."""

    name: str
    sent: Sequence[Callable[[int], Message]]
    told: str
    type_name: str = "graphnav_lcm.image_t"


def _stamp() -> int:
    return time.time_ns() // 1000


def image(
    channel: str = "CAMERA", size: int | None = None, first_seq: int = 0, **changed: Any
) -> Callable[[int], Message]:
    """Return the sender of a picture with changed fields; ``size`` overwrites the size field."""

    def send(k: int) -> Message:
        fields = {"utime": _stamp(), "seq": first_seq + k, "step_px": 0, "rows": ROWS, "cols": COLS, "channels": 1}
        data = IMAGE.encode({**fields, "data": FLOOR.tobytes(), **changed})
        if size is not None:
            data = data[:40] + size.to_bytes(4, "big") + data[44:]
        return channel, data

    return send


def bot_core(**changed: Any) -> Callable[[int], Message]:
    """Return the sender of a ``bot_core.image_t`` with changed fields."""

    def send(_: int) -> Message:
        fields = {"utime": _stamp(), "width": COLS, "height": ROWS, "row_stride": COLS, "pixelformat": 1497715271}
        return "CAMERA", BOT_CORE.encode({**fields, "data": FLOOR.tobytes(), "metadata": (), **changed})

    return send


def odometry(**changed: Any) -> Callable[[int], Message]:
    """Return the sender of odometry at rest with changed fields."""

    def send(k: int) -> Message:
        fields = {"x_m": 0.0, "y_m": 0.0, "yaw_rad": 0.0, "v_mps": 0.0, "omega_radps": 0.0}
        return "ODOMETRY", ODOMETRY.encode({"utime": _stamp(), "seq": k, **fields, **changed})

    return send


def _bytes(data: bytes) -> Callable[[int], Message]:
    return lambda _: ("CAMERA", data)


def _twist(_: int) -> Message:
    return "CAMERA", TWIST.encode({"utime": _stamp(), "seq": 0, "v_mps": 0.0, "omega_radps": 0.0})


def _resized(k: int) -> Message:
    return image(rows=60, cols=80, data=bytes(60 * 80))(k) if k % 2 else image()(k)


def _in_ms(k: int) -> Message:
    return image(utime=_stamp() // 1000)(k)


BOT = "bot_core.image_t"
MISTAKES = (
    Mistake("rows is left at 0", [image(rows=0)], "image_t: rows is 0, expected 1 or more"),
    Mistake("channels is left at 0", [image(channels=0)], "image_t: channels is 0, expected 1 (gray) or 3"),
    Mistake("RGBA", [image(channels=4, data=bytes(4 * ROWS * COLS))], "image_t: channels is 4, expected 1 (gray) or 3"),
    Mistake(
        "gray pixels declared as colour",
        [image(channels=3)],
        "image_t: size is 19200, expected rows * cols * channels = 120 * 160 * 3 = 57600",
    ),
    Mistake("size larger than the data", [image(size=57600)], "data has size = 57600 elements, which need 57600 bytes"),
    Mistake("size smaller than the data", [image(size=100)], "its fields end at byte 144 where size = 100"),
    Mistake("step_px is negative", [image(step_px=-1)], "image_t: step_px is -1, expected 1 or more; 0 counts as 1"),
    Mistake("the picture changes its size", [_resized], ", as in the first message"),
    Mistake(
        "another message on the channel",
        [_twist],
        "the messages are graphnav_lcm.twist_t, expected graphnav_lcm.image_t",
    ),
    Mistake(
        "a struct of other fields",
        [_bytes(bytes(range(1, 60)))],
        "the fingerprint 0102030405060708 is not of an installed",
    ),
    Mistake(
        "a JPEG without a message around it", [_bytes(JPEG)], f"the fingerprint {JPEG[:8].hex()} is not of an installed"
    ),
    Mistake(
        "odometry with a NaN",
        [image(), odometry(yaw_rad=math.nan)],
        "odometry_t: yaw_rad is nan, expected a finite number",
    ),
    Mistake("row_stride is left at 0", [bot_core(row_stride=0)], "row_stride is 0, expected 160 or more", BOT),
    Mistake("pixelformat is left at 0", [bot_core(pixelformat=0)], "pixelformat is 0, expected 1497715271 (GREY)", BOT),
    Mistake(
        "a truncated JPEG", [bot_core(pixelformat=MJPEG, data=JPEG[:-300])], "data is a JPEG that is truncated", BOT
    ),
    Mistake("the channel is CAM0", [image("CAM0")], "; CAM0 carries graphnav_lcm.image_t at "),
    Mistake("two drivers", [image(first_seq=5230), image(first_seq=17)], "two writers: seq "),
    Mistake("two drivers that leave seq at 0", [image(seq=0), image(seq=0)], "2 writers without sequence numbers: "),
    Mistake("two drivers of a type without seq", [bot_core(), bot_core()], "2 writers without sequence numbers: ", BOT),
    Mistake("stamps in milliseconds", [_in_ms], "stamps look like milliseconds"),
)
HARMLESS = Mistake("a zeroed struct: step_px and seq are 0", [image(seq=0), odometry()], "")


@pytest.mark.parametrize("mistake", [*MISTAKES, HARMLESS], ids=lambda mistake: mistake.name)
def test_mistakes(targets: Targets, tmp_path: Path, mistake: Mistake) -> None:
    """Make a mistake live; print the line that tells it."""
    url = group_url(NUMBER)
    (tmp_path / "graph.yaml").write_text(GRAPH.format(type=mistake.type_name))
    output = tmp_path / "run.txt"
    with running(graphnav_run(tmp_path / "graph.yaml", url, tmp_path / "run"), output) as process:
        printed = _send(url, mistake, output, process)
    if mistake.told:
        line = next((line.strip() for line in printed.splitlines() if mistake.told in line), None)
        targets.check(f"{mistake.name}: {line or f'printed {printed[-800:]!r}'}", good=line is not None)
        return
    summary = json.loads((tmp_path / "run" / "summary.json").read_text())
    (camera,) = (one for one in summary["live"]["inputs"] if one["channel"] == "CAMERA")
    told = [line for line in summary["notices"] if "camera" in line]
    good = camera["accepted"] > 0 and not camera["reasons"] and not told
    targets.check(f"{mistake.name}: {camera['accepted']} pictures used {told}", good=good)


def _send(url: str, mistake: Mistake, output: Path, process: subprocess.Popen[bytes]) -> str:
    """Make the mistake until it is told, or for a while if nothing is to be told; return what was printed."""
    programs = [lcm.LCM(url) for _ in mistake.sent]
    others = [] if any(send(0)[0] == "ODOMETRY" for send in mistake.sent) else [odometry()]
    end_s, printed = time.monotonic() + (PATIENCE_S if mistake.told else RUN_S), ""
    k = 0
    while time.monotonic() < end_s and process.poll() is None:
        for program, send in zip(programs, mistake.sent, strict=True):
            program.publish(*send(k))
        for send in others:
            programs[0].publish(*send(k))
        k += 1
        time.sleep(PERIOD_S)
        printed = output.read_text()
        if mistake.told and mistake.told in printed:
            break
    return printed
