"""Measure ROS 2 topics of live graphs: with a robot in C, and a drive of the simulated robot beside the same by LCM.

usage: bench_ros2.py [--seconds 60] [--drive-s 60] [--rate 10] [--size 640x480]

The robot in C (testbed/ros2_c) needs Debian's packages cyclonedds-dev and cyclonedds-tools, and gcc; without them that
part is left out. The first part prints for each topic what was sent and what came, and whether stamps were kept; the
second one whether the robot arrived, and the latency from the picture's arrival to the command, of ROS 2 and of LCM.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import shutil
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from taking_turns import load_told
from testbed.drives import GRAPHNAV
from testbed.ros_peer import LOOPBACK

from graphnav import Recording

TOOLS = Path(__file__).parent
DOMAIN = 71
URLS = tuple(f"udpm://239.255.90.{number}:{7990 + number}?ttl=0&recv_buf_size=2097152" for number in (1, 2))
PEER = """
extends: navigate_ros2
ros2: {{domain: {domain}}}
run: {{record: all}}
inputs:
  base.odometry: {{ros2: /odom, type: nav_msgs/Odometry}}
  front.image: {{ros2: /camera/compressed, type: sensor_msgs/CompressedImage}}
"""
DRIVE = """
extends: navigate_ros2
ros2: {{domain: {domain}}}
outputs: {{local.local_map: null}}
"""
REFS = {"/camera/image_raw": "camera.image", "/camera/compressed": "front.image", "/odom": "base.odometry"}
START_S = 15.0
"""The run has this long to begin before the robot does."""


def built(folder: Path) -> Path | None:
    """Return the robot in C, None where it cannot be built."""
    if shutil.which("idlc") is None or shutil.which("gcc") is None:
        return None
    source = TOOLS / "testbed" / "ros2_c"
    for name in ("ros.idl", "peer.c"):
        shutil.copy(source / name, folder)
    subprocess.run(["idlc", "-l", "c", "ros.idl"], cwd=folder, check=True)
    subprocess.run(["gcc", "-O2", "-o", "peer", "peer.c", "ros.c", "-I.", "-lddsc"], cwd=folder, check=True)
    return folder / "peer"


def live_run(graph: str, url: str, folder: Path, until_s: float) -> subprocess.Popen[bytes]:
    """Start a run; what it prints is in ``folder.txt``."""
    words = ["run", graph, "--url", url, "--until", str(until_s), "--no-tap", "--no-pictures", "--json"]
    with folder.with_suffix(".txt").open("wb") as output:
        return subprocess.Popen([str(GRAPHNAV), *words, "-o", str(folder)], stdout=output, stderr=subprocess.STDOUT)


def summary_of(folder: Path) -> Mapping[str, Any]:
    """Return the summary of a run."""
    found: Mapping[str, Any] = json.loads((folder / "summary.json").read_text())
    return found


def beside_c(peer: Path, folder: Path, seconds: float, rate_hz: float, size: tuple[int, int]) -> Mapping[str, Any]:
    """Let the robot in C send and hear for so long; return what was measured."""
    cols, rows = size
    graph, jpeg, run = folder / "peer.yaml", folder / "picture.jpg", folder / "run"
    graph.write_text(PEER.format(domain=DOMAIN))
    noise = np.random.default_rng(1).integers(0, 255, (rows // 8, cols // 8), np.uint8)
    jpeg.write_bytes(cv2.imencode(".jpg", cv2.resize(noise, (cols, rows)))[1].tobytes())
    process = live_run(str(graph), URLS[0], run, seconds + START_S + 5.0)
    time.sleep(START_S)
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    words = [str(peer), str(DOMAIN), str(seconds), str(rate_hz), str(cols), str(rows), str(jpeg)]
    told = subprocess.run(
        words, check=True, capture_output=True, text=True, env=os.environ | {"CYCLONEDDS_URI": LOOPBACK}
    )
    lines = [line.split() for line in told.stdout.splitlines()]
    peer_s = next(float(line[1]) for line in lines if line[0] == "cpu")
    process.wait()
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    inputs = {one["name"]: one for one in summary_of(run)["live"]["inputs"]}
    heard = Counter(line[1] for line in lines if line[0] == "heard")
    found: dict[str, Any] = {"topics": {}, "heard": dict(heard), "peer_cpu_s": peer_s}
    found["run_cpu_s"] = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime - peer_s
    with Recording(run / "run.lcmlog") as log:
        for topic, ref in REFS.items():
            sent = [int(line[2]) for line in lines if line[0] == "sent" and line[1] == topic]
            kept = log.utimes(ref) if log.count(ref) else []
            found["topics"][topic] = {
                "sent": len(sent),
                "accepted": inputs[ref]["accepted"],
                "rejected": sum(inputs[ref]["rejected"]),
                "recorded": len(kept),
                "stamps_kept": set(kept) <= set(sent),
            }
    return found


def drive(folder: Path, seconds: float, *, by_ros: bool) -> Mapping[str, Any]:
    """Drive the simulated robot for so long, by ROS 2 through a bridge, or by LCM; return what was measured."""
    robot = live_run("robot_live", URLS[0], folder / "robot", seconds + START_S)
    bridge = None
    if by_ros:
        (folder / "drive.yaml").write_text(DRIVE.format(domain=DOMAIN))
        words = [sys.executable, str(TOOLS / "testbed" / "ros_bridge.py"), str(DOMAIN), URLS[0]]
        bridge = subprocess.Popen(words, env=os.environ | {"CYCLONEDDS_URI": LOOPBACK, "PYTHONPATH": str(TOOLS)})
    graph = str(folder / "drive.yaml") if by_ros else "navigate_robot"
    navigation = live_run(graph, URLS[1] if by_ros else URLS[0], folder / "navigation", seconds + START_S)
    navigation.wait()
    robot.wait()
    if bridge is not None:
        bridge.kill()
        bridge.wait()
    told, truth = summary_of(folder / "navigation"), summary_of(folder / "robot")
    command = next(one for one in told["live"]["outputs"] if one["name"] == "guard.twist")
    picture = next(one for one in told["live"]["inputs"] if one["name"] == "camera.image")
    latency = {name: command[f"latency_{name}_ms"] for name in ("p50", "p99", "max")}
    return {"pictures": picture["accepted"], "commands": command["sent"], "ms": latency, "scores": truth["scores"]}


def table(rows: Sequence[Sequence[object]]) -> None:
    """Print rows in columns."""
    widths = [max(len(str(row[k])) for row in rows) for k in range(len(rows[0]))]
    for row in rows:
        print("  ".join(str(cell).ljust(width) for cell, width in zip(row, widths, strict=True)))


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--drive-s", type=float, default=60.0)
    parser.add_argument("--rate", type=float, default=10.0)
    parser.add_argument("--size", default="640x480")
    args = parser.parse_args()
    cols, rows = map(int, args.size.split("x"))
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        peer = built(folder) if args.seconds else None
        if peer is not None:
            found = beside_c(peer, folder, args.seconds, args.rate, (cols, rows))
            print(f"{args.seconds:g} s beside a robot in C, {args.rate:g} Hz, pictures of {args.size}:")
            names = ("sent", "accepted", "rejected", "recorded", "stamps_kept")
            table([("topic", *names), *((topic, *map(one.get, names)) for topic, one in found["topics"].items())])
            print(f"heard by the robot: {found['heard']}")
            print(f"processor time: run {found['run_cpu_s']:.1f} s, robot {found['peer_cpu_s']:.1f} s")
        for by_ros in (False, True) if args.drive_s else ():
            where = folder / f"drive-{by_ros}"
            where.mkdir()
            found = drive(where, args.drive_s, by_ros=by_ros)
            ms = ", ".join(f"{name} {value:.1f}" for name, value in found["ms"].items())
            print(
                f"{'ROS 2' if by_ros else 'LCM'}: {found['pictures']} pictures, {found['commands']} commands, ms: {ms}"
            )
            print(f"  {found['scores']}")


if __name__ == "__main__":
    with load_told():
        main()
