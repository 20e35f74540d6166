"""Measures that depend on the machine: memory, reception by a logger, Ctrl-C, a fresh clone."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import lcm
import pytest
from testbed.drives import GRAPHNAV
from testbed.processes import await_file

from graphnav import Recording
from graphnav.core.bus import Bus
from tests.targets import Targets

ROOT = Path(__file__).resolve().parents[2]
WANDER = "teach_downward"
MAX_PEAK_MB = 250
MAX_END_S = 1.0


def test_memory(targets: Targets, tmp_path: Path) -> None:
    """The peak memory of a run of 60 s and of one of 600 s of simulated time."""
    peaks = [_peak_mb(until_s, tmp_path / f"{until_s}") for until_s in (60, 600)]
    text = f"peak memory {peaks[0]:.1f} MB in 60 s, {peaks[1]:.1f} MB in 600 s (below {MAX_PEAK_MB})"
    targets.check(text, good=abs(peaks[1] / peaks[0] - 1) <= 0.05 and max(peaks) < MAX_PEAK_MB)


def _peak_mb(until_s: float, folder: Path) -> float:
    """Return the peak resident memory of a run on the empty floor, where no drive ends early."""
    command = [str(GRAPHNAV), "run", WANDER, "--until", str(until_s), "--no-tap", "-o", str(folder)]
    code = (
        "import resource, subprocess, sys; subprocess.run(sys.argv[1:], check=True, stdout=subprocess.DEVNULL);"
        "print(resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss)"
    )
    done = subprocess.run([sys.executable, "-c", code, *command], capture_output=True, text=True, check=True)
    return int(done.stdout.split()[-1]) / 1024


@pytest.mark.parametrize(
    ("tap", "buffer", "min_share"), [("full", "&recv_buf_size=2097152", 0.0), ("thin", "", 0.99)], ids=["full", "thin"]
)
def test_heard(targets: Targets, tmp_path: Path, tap: str, buffer: str, min_share: float) -> None:
    """The share of the messages that lcm-logger gets: full with a large buffer, thinned with a stock one."""
    ours, theirs, wrong = _logged(tap, buffer, tmp_path)
    share = theirs / ours
    text = f"--tap {tap}: lcm-logger got {theirs} of {ours} ({share:.4f}, at least {min_share}), {wrong} differ"
    targets.check(text, good=not wrong and share >= min_share)


def _logged(tap: str, buffer: str, folder: Path) -> tuple[int, int, int]:
    """Return the numbers of messages in our log, in lcm-logger's, and of those in theirs that differ from ours."""
    heard = folder / "heard.lcmlog"
    logger = subprocess.Popen(
        [str(Path(lcm.LCM_BIN_DIR) / "lcm-logger"), "--quiet", "--lcm-url", Bus.GROUP + buffer, str(heard)]
    )
    time.sleep(1)
    command = [str(GRAPHNAV), "run", "corridor_ccw", "--seed", "3", "--pace", "1", "--tap", tap, "--until", "30"]
    command += ["--record", "all", "--no-pictures", "-o", str(folder / "run")]
    subprocess.run(command, check=True, capture_output=True, env={**os.environ, "LCM_DEFAULT_URL": Bus.GROUP})
    time.sleep(1)
    logger.terminate()
    logger.wait()
    with Recording(folder / "run" / "run.lcmlog") as ours, Recording(heard) as theirs:
        sent = {(e.channel, e.data) for e in ours.events()}
        channels = {e.channel for e in ours.events()} - {"graphnav.about"}
        count = sum(ours.count(channel) for channel in channels)
        received = {(e.channel, e.data) for e in theirs.events() if e.channel in channels}
        wrong = len(received - sent) if tap == "full" else 0
    return count, len(received), wrong


@pytest.mark.parametrize("after_s", [0.5, 1.0, 1.7, 2.9, 4.1])
def test_interrupt(targets: Targets, tmp_path: Path, after_s: float) -> None:
    """Press Ctrl-C during a drive: how long it then takes to end, log and summary written."""
    command = [str(GRAPHNAV), "run", "corridor_ccw", "--pace", "2", "-o", str(tmp_path / "run")]
    run = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    log = tmp_path / "run" / "run.lcmlog"
    await_file(log)
    time.sleep(after_s)
    run.send_signal(signal.SIGINT)
    begin_s = time.monotonic()
    run.wait()
    took_s = time.monotonic() - begin_s
    with Recording(log) as recording:
        assert recording.truncated is None
    assert json.loads((tmp_path / "run" / "summary.json").read_text())["outcome"] == "stopped"
    targets.check(f"Ctrl-C: ended within {took_s:.2f} s, log and summary complete", good=took_s <= MAX_END_S)


@pytest.mark.parametrize("name", ["plain", "with a space"])
def test_fresh(targets: Targets, tmp_path: Path, name: str) -> None:
    """Clone into an empty folder, and into one with a space in its path, and run the two lines of the README."""
    lines = re.findall(r"^python3 -m venv .*$", (ROOT / "README.md").read_text(), re.MULTILINE)
    assert len(lines) == 2
    folder = tmp_path / name
    subprocess.run(["git", "clone", "-q", str(ROOT), str(folder)], check=True)
    for line in lines:
        begin_s = time.monotonic()
        done = subprocess.run(["bash", "-c", line], cwd=folder, check=False, capture_output=True, text=True)
        failed = re.findall(r"^(?:FAILED|ERROR) .*$", done.stdout, re.MULTILINE)
        last = failed or done.stdout.strip().splitlines()[-1:]
        text = f"'{name}': {line[:60]}… {time.monotonic() - begin_s:.0f} s: {last}"
        targets.check(text, good=done.returncode == 0)
    runs = [sorted(path.name for path in run.iterdir()) for run in folder.glob("runs/*")]
    wanted = {"run.lcmlog", "graph.yaml", "summary.json", "map.png", "panels.png"}
    targets.check(f"left {runs}", good=bool(runs) and wanted <= set(runs[0]))
