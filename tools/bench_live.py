"""Benchmark the latency from image to command: a live graph against a bare python-lcm loop with the same stages.

The graph runs in one process, and with one for each stage.

A recorded drive is played to both, with new stamps, in real time: the camera at 10 Hz, odometry at 50 Hz. As on a robot
the two have clocks of their own: the camera's is slow by 2 in 1000, so that an image waits for the odometry after it by
anything from nothing to 20 ms, alike in both. What is timed is what a robot would see: from the publication of an image
to the arrival of the next command; beside it, how much of that is left once image and odometry have been published. The
graph's guard fires on commands alone here, so that every command answers an image. ``python tools/bench_live.py
[CAMERA ...]`` measures the cameras of `CAMERAS`, all of them without arguments.

Last the drive at 640x480 is played at 30 Hz for 60 s, forth and back, to `navigate_live`: its summary tells how many
frames were overtaken or lost, with Lucas-Kanade, and with DIS where the machine is too slow for that.
``python tools/bench_live.py 30hz`` measures that alone.
"""

from __future__ import annotations

import itertools
import json
import os
import statistics
import subprocess
import sys
import tempfile
import threading
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

import lcm
from taking_turns import load_told, results_in_turn
from testbed.drives import GRAPHNAV
from testbed.processes import await_listeners
from testbed.rig import Rig

from graphnav import Recording
from graphnav.core.machine.threads import ONE_THREAD

BARE = Path(__file__).with_name("bare_navigation.py")
PORT = 7999
URL = f"udpm://239.255.82.1:{PORT}?ttl=0&recv_buf_size=2097152"
PLAYED = {"robot.image": "CAMERA", "robot.odometry": "ODOMETRY"}
ON_COMMANDS = "extends: navigate_live\nstages: {guard: {every_ms: 60000}}\n"
LARGE = ("planar.model=models/downward_640x480.lcmlog",)
CAMERAS: dict[str, tuple[str, Sequence[str]]] = {
    "160x120": ("[160,120]", ()),
    "640x480": ("[640,480]", LARGE),
    "640x480-dis": ("[640,480]", ("flow=flow.dis", "flow.preset=fast", *LARGE)),
}
"""By name: the size of the image, and what is set in the graph that sees it."""
MAX_RATIO = 1.15
"""Of the graph in one process to the bare loop."""
MAX_PROCESSES_RATIO = 1.5
"""Of the graph in many processes to the one in one."""
FAST, FAST_CAMERAS = "30hz", ("640x480", "640x480-dis")
FAST_HZ, FAST_S = 30, 60
_RECORDED_HZ = 10
_SLOW_CAMERA_RATIO = 0.002
_WARM_UP = 10
_START_S = 60.0
_MAX_ANSWER_S = 0.09

Event = tuple[int, str, bytes]


class Answer(NamedTuple):
    """Seconds from an image, and from the later of it and the odometry that covers it, to the command."""

    since_image_s: float
    since_complete_s: float


def record(folder: Path, duration_s: float, camera: str) -> list[Event]:
    """Drive live for a while; return what the robot published: stamp, channel, bytes."""
    size, sets = CAMERAS[camera]
    options = ["--until", str(duration_s + 4), "--set", "run.record=all", "--set", f"robot.size={size}"]
    with Rig(folder, 99, 5, options) as rig:
        rig.navigate(options=_set(sets))
        rig.finish()
    with Recording(folder / "robot" / "run.lcmlog") as log:
        events = [
            (utime, channel, log.event(name, k).data)
            for name, channel in PLAYED.items()
            for k, utime in enumerate(log.utimes(name))
        ]
    begin = min(events)[0] + 3_000_000
    kept = (event for event in events if begin <= event[0] < begin + duration_s * 1e6)
    return sorted((_slowed(utime - begin, channel), channel, data) for utime, channel, data in kept)


def _slowed(utime: int, channel: str) -> int:
    return round(utime * (1 + _SLOW_CAMERA_RATIO)) if channel == "CAMERA" else utime


def play(events: Sequence[Event]) -> list[Answer]:
    """Play a drive once; return how long each answered image waited for its command."""
    publisher, listener = lcm.LCM(URL), lcm.LCM(URL)
    commands: list[float] = []
    listener.subscribe("BASE_CMD", lambda _channel, _data: commands.append(time.perf_counter()))
    ending = threading.Event()

    def listen() -> None:
        while not ending.is_set():
            listener.handle_timeout(20)

    thread = threading.Thread(target=listen)
    thread.start()
    begin_s, first = time.perf_counter(), events[0][0]
    shift = time.time_ns() // 1000 - first
    sent: dict[str, list[float]] = {"CAMERA": [], "ODOMETRY": []}
    for utime, channel, data in events:
        wait_s = begin_s + (utime - first) / 1e6 - time.perf_counter()
        if wait_s > 0:
            time.sleep(wait_s)
        stamped = data[:8] + (utime + shift).to_bytes(8, "big", signed=True) + data[16:]
        sent[channel].append(time.perf_counter())
        publisher.publish(channel, stamped)
    time.sleep(0.2)
    ending.set()
    thread.join()
    answers = []
    for image_s in sent["CAMERA"]:
        after = next((command_s for command_s in commands if command_s > image_s), None)
        covered_s = next((odometry_s for odometry_s in sent["ODOMETRY"] if odometry_s > image_s), None)
        if after is not None and covered_s is not None and after - image_s < _MAX_ANSWER_S:
            answers.append(Answer(after - image_s, after - covered_s))
    return answers


def at_30_hz(events: Sequence[Event], n_frames: int) -> Iterator[Event]:
    """Yield a drive three times as fast, forth and back until so many images have come; stamps from 0 on."""
    first, last = events[0][0], events[-1][0]
    forth = [(utime - first, channel, data) for utime, channel, data in events]
    back = [(last - utime, channel, data) for utime, channel, data in reversed(events)]
    count = 0
    for turn in itertools.count():
        for utime, channel, data in (back if turn % 2 else forth)[turn > 0 :]:  # the last one was sent already
            count += channel == "CAMERA"
            yield (turn * (last - first) + utime) * _RECORDED_HZ // FAST_HZ, channel, data
            if count == n_frames:
                return


def frames_missed(events: Sequence[Event], camera: str, scratch: Path, *more: str) -> tuple[int, int]:
    """Play a drive at 30 Hz to a live graph; return how many frames were overtaken or lost, and how many were sent.

    ``more``: further options of the run.
    """
    publisher, n_frames, sent = lcm.LCM(URL), FAST_HZ * FAST_S, Counter[str]()
    folder = Path(tempfile.mkdtemp(dir=scratch)) / "run"
    options = ["--url", URL, "--no-pictures", *_set(CAMERAS[camera][1]), *more, "-o", str(folder)]
    with running([str(GRAPHNAV), "run", "navigate_live", *options]):
        begin_s, shift = time.perf_counter(), time.time_ns() // 1000
        for utime, channel, data in at_30_hz(events, n_frames):
            wait_s = begin_s + utime / 1e6 - time.perf_counter()
            if wait_s > 0:
                time.sleep(wait_s)
            stamp_and_number = (utime + shift).to_bytes(8, "big", signed=True) + sent[channel].to_bytes(8, "big")
            publisher.publish(channel, data[:8] + stamp_and_number + data[24:])
            sent[channel] += 1
        time.sleep(1)
    summary = json.loads((folder / "summary.json").read_text())
    return n_frames - summary["stages"]["flow"]["steps"], n_frames


@contextmanager
def running(command: Sequence[str]) -> Iterator[None]:
    """Run a program while entered."""
    with tempfile.TemporaryFile() as output:
        process = subprocess.Popen(command, stdout=output, stderr=output, env=os.environ | ONE_THREAD)
        try:
            await_listeners(PORT, 1, _START_S)
            time.sleep(2)
            yield
        finally:
            process.terminate()
            process.wait(30)


def measure(camera: str, turns: int = 3, duration_s: float = 15.0) -> dict[str, dict[str, float]]:
    """Return median and 99th percentile in ms and the number of answers, of the graph and of its rivals."""
    with tempfile.TemporaryDirectory() as scratch:
        events = record(Path(scratch) / "drive", duration_s, camera)
        graph = Path(scratch) / "on_commands.yaml"
        graph.write_text(ON_COMMANDS)
        sets = CAMERAS[camera][1]
        options = ["--url", URL, "--no-pictures", *_set(sets)]

        def answers(*command: str) -> list[Answer]:
            with running(command):
                return play(events)[_WARM_UP:]

        def of_graph(*more: str) -> list[Answer]:
            folder = tempfile.mkdtemp(dir=scratch)
            return answers(str(GRAPHNAV), "run", str(graph), *options, *more, "-o", f"{folder}/run")

        rivals = {
            "graph": of_graph,
            "processes": lambda: of_graph("--processes"),
            "bare": lambda: answers(sys.executable, str(BARE), URL, *sets),
        }
        found = results_in_turn(rivals, turns)
    return {name: _statistics([one for turn in of for one in turn]) for name, of in found.items()}


def _set(sets: Sequence[str]) -> list[str]:
    """Return the options of the command line that set these."""
    return [word for one in sets for word in ("--set", one)]


def _statistics(found: Sequence[Answer]) -> dict[str, float]:
    since_image_s = [one.since_image_s for one in found]
    return {
        "p50": statistics.median(since_image_s) * 1e3,
        "p99": statistics.quantiles(since_image_s, n=100)[98] * 1e3,
        "complete": statistics.median(one.since_complete_s for one in found) * 1e3,
        "answers": len(found),
    }


def main() -> int:
    """Print both and their ratio for each camera; return 1 if one is above what is asked."""
    missed, chosen = 0, sys.argv[1:] or [*CAMERAS, FAST]
    for camera in chosen:
        if camera == FAST:
            missed += not keeps_up()
            continue
        found = measure(camera)
        for name, values in found.items():
            print(
                f"{camera} {name:9} p50 {values['p50']:.2f} ms, p99 {values['p99']:.2f} ms since the image, "
                f"p50 {values['complete']:.2f} ms since image and odometry; {values['answers']} answers"
            )
        for name, other, max_ratio in (("graph", "bare", MAX_RATIO), ("processes", "graph", MAX_PROCESSES_RATIO)):
            ratio = found[name]["p50"] / found[other]["p50"]
            missed += ratio > max_ratio
            verdict = "ok  " if ratio <= max_ratio else "MISS"
            print(f"{verdict} {name} to {other}, of the medians {ratio:.3f}, at most {max_ratio}")
    return 1 if missed else 0


def keeps_up() -> bool:
    """Print what became of a drive at 30 Hz, for each flow in one process and in many; return if one took all."""
    with tempfile.TemporaryDirectory() as scratch:
        events = record(Path(scratch) / "drive", 15.0, FAST_CAMERAS[0])
        fewest = FAST_HZ * FAST_S
        for camera, more in itertools.product(FAST_CAMERAS, ((), ("--processes",))):
            n_missed, n_frames = frames_missed(events, camera, Path(scratch), *more)
            fewest = min(fewest, n_missed)
            verdict = "MISS" if n_missed else "ok  "
            told = f"{camera}, {'a process for each stage' if more else 'one process'}"
            print(
                f"{verdict} {FAST_HZ} Hz for {FAST_S} s, {told}: overtaken or lost {n_missed} of {n_frames}", flush=True
            )
    return not fewest


if __name__ == "__main__":
    with load_told():
        sys.exit(main())
