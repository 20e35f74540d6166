"""Large pictures: how many of 300 reach unmodified receivers with stock buffers, sent by LCM and sent by graphnav."""

from __future__ import annotations

import json
import os
import resource
import signal
import subprocess
import sys
import time
from itertools import product
from pathlib import Path
from typing import NamedTuple

import lcm
import numpy as np
import pytest
from testbed.processes import await_file, end, group_url

from graphnav import Image, Recording
from graphnav.core.bus import Bus
from graphnav.core.codec import encode
from graphnav.core.machine.receive_buffer import ReceiveBuffer
from tests.targets import Targets

from .foreign_listeners import c_listener, java_listener

N = 300
SHAPES = {"307 kB": (480, 640), "922 kB": (480, 640, 3)}
RATES_HZ = (10, 30)
STOCK_BYTES = 212_992
MIN_SHARE = 0.99
"""The share that has to arrive of what graphnav sends: an idle machine loses nothing, a busy one some."""
CHANNEL = "CAMERA"
TYPES = {CHANNEL: "graphnav_lcm.image_t"}
SETTLED_S = 1.0
PYTHON = f"""
import lcm, select, sys
bus, count = lcm.LCM(sys.argv[1] + "&recv_buf_size={STOCK_BYTES}"), 0
def hear(_channel, _data):
    global count
    count += 1
bus.subscribe("{CHANNEL}", hear).set_queue_capacity(0)
print("ready", flush=True)
while sys.stdin not in select.select([bus, sys.stdin], [], [])[0]:
    bus.handle()
print("{CHANNEL}", count, 0, 0)
"""


class Cost(NamedTuple):
    """The average cost of a message, milliseconds: processor time here and in the process that sends."""

    own_ms: float
    process_ms: float
    worst_ms: float
    """The longest time that the sender was kept waiting."""
    overtaken: int
    """Messages that were not sent because a newer one was pending."""


def test_large(targets: Targets, tmp_path: Path, pytestconfig: pytest.Config) -> None:
    """Measure in a network namespace of its own, where no other traffic is; print what arrived and what it took."""
    inside = [sys.executable, "-m", "tests.slow.test_large_pictures", str(tmp_path)]
    command = ["unshare", "-rn", "sh", "-c", f'{Bus.MAKE_ROUTE} && exec "$@"', "sh", *inside]
    root = pytestconfig.rootpath
    env = os.environ | {"PYTHONPATH": str(root / "tools")}  # where the test's own imports are found
    with subprocess.Popen(command, cwd=root, env=env, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        for line in process.stdout:
            is_judged, good, text = json.loads(line)
            if is_judged:
                targets.check(text, good=good)
            else:
                targets.say(text)
    assert not process.returncode


def main(folder: Path) -> None:
    """Measure every size and rate; print whether it is judged, whether that is good, and what it is, line by line."""
    held_bytes = ReceiveBuffer.measured(STOCK_BYTES).held_bytes
    _tell(f"a buffer of {STOCK_BYTES} bytes holds messages up to {held_bytes / 1e3:.0f} kB in one burst")
    url = group_url(234)
    programs = {
        "C": c_listener(folder / "c", TYPES, url),
        "python-lcm": [sys.executable, "-c", PYTHON, url],
    }
    if java := java_listener(folder / "java", TYPES, url):
        programs["lcm-spy's Java"] = java
    for (size, shape), rate_hz, is_ours in product(SHAPES.items(), RATES_HZ, (False, True)):
        log = folder / f"{size}-{rate_hz}-{is_ours}.lcmlog"
        received, cost = _measured(programs, url, log, shape, rate_hz, is_ours=is_ours)
        text = f"{size} at {rate_hz} Hz by {'graphnav' if is_ours else 'LCM'}: "
        text += ", ".join(f"{name} {count}" for name, count in received.items())
        text += f" of {N}; {cost.own_ms:.2f} ms a message here, at most {cost.worst_ms:.1f} ms; "
        text += f"{cost.process_ms:.2f} ms in the process that sends, which left out {cost.overtaken}"
        _tell(text, good=min(received.values()) >= MIN_SHARE * N if is_ours else None)


def _tell(text: str, *, good: bool | None = None) -> None:
    print(json.dumps([good is not None, good, text]), flush=True)


def _measured(
    programs: dict[str, list[str]], url: str, log: Path, shape: tuple[int, ...], rate_hz: int, *, is_ours: bool
) -> tuple[dict[str, int], Cost]:
    """Send to all programs at once; return how many messages each received, and what sending took."""
    started = {
        name: subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        for name, command in programs.items()
    }
    command = [str(Path(lcm.LCM_BIN_DIR) / "lcm-logger"), "--quiet", "--lcm-url", url, str(log)]
    logger = subprocess.Popen(command, stdout=subprocess.DEVNULL)
    for program in started.values():
        assert program.stdout is not None
        program.stdout.readline()
    await_file(log)
    time.sleep(SETTLED_S)
    cost = _send(url, shape, rate_hz, is_ours=is_ours)
    time.sleep(SETTLED_S)
    end(logger)
    with Recording(log) as recording:
        received = {"lcm-logger": recording.count(CHANNEL)}
    for name, program in started.items():
        words = program.communicate("\n")[0].split()
        received[name] = int(words[1]) if words else 0
    return received, cost


def _send(url: str, shape: tuple[int, ...], rate_hz: int, *, is_ours: bool) -> Cost:
    bus = Bus(url)
    data = [encode(Image(pixels=np.full(shape, k, np.uint8)), 0, k) for k in range(8)]
    before, own_s, worst_s = _children_s(), 0.0, 0.0
    due_s = time.monotonic()
    for k in range(N):
        time.sleep(max(0.0, due_s - time.monotonic()))
        due_s += 1 / rate_hz
        begin_s, cpu_s = time.monotonic(), time.thread_time()
        if is_ours:
            bus.send(CHANNEL, data[k % len(data)], newest_only=True)
        else:
            bus.publish(CHANNEL, data[k % len(data)])
        own_s += time.thread_time() - cpu_s
        worst_s = max(worst_s, time.monotonic() - begin_s)
    time.sleep(SETTLED_S)
    bus.close()
    return Cost(own_s / N * 1e3, (_children_s() - before) / N * 1e3, worst_s * 1e3, sum(bus.overtaken.values()))


def _children_s() -> float:
    """Return the processor time of the ended child processes."""
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


if __name__ == "__main__":
    signal.signal(signal.SIGINT, signal.default_int_handler)
    main(Path(sys.argv[1]))
