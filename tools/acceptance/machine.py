"""Acceptance tests that depend on the machine: memory, reception by a logger, a fresh clone."""

from __future__ import annotations

import json
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

import lcm

from acceptance.drives import GRAPHNAV, say
from graphnav import Recording
from graphnav.core.bus import GROUP

ROOT = Path(__file__).resolve().parent.parent.parent
WANDER = "teach_downward"
MAX_PEAK_MB = 250


def memory_item(_seeds: Sequence[int], _jobs: int) -> bool:
    """Print the peak memory of a run of 60 s and of one of 600 s of simulated time."""
    peaks = [_peak_mb(until_s) for until_s in (60, 600)]
    good = abs(peaks[1] / peaks[0] - 1) <= 0.05 and max(peaks) < MAX_PEAK_MB
    mark = "ok  " if good else "MISS"
    say(f"{mark} peak memory {peaks[0]:.1f} MB in 60 s, {peaks[1]:.1f} MB in 600 s (below {MAX_PEAK_MB})")
    return good


def _peak_mb(until_s: float) -> float:
    """Return the peak resident memory of a run on the empty floor, where no drive ends early."""
    with tempfile.TemporaryDirectory() as scratch:
        command = [str(GRAPHNAV), "run", WANDER, "--until", str(until_s), "--no-tap"]
        code = (
            "import resource, subprocess, sys; subprocess.run(sys.argv[1:], check=True, stdout=subprocess.DEVNULL);"
            "print(resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss)"
        )
        done = subprocess.run(
            [sys.executable, "-c", code, *command, "-o", f"{scratch}/run"], capture_output=True, text=True, check=True
        )
    return int(done.stdout.split()[-1]) / 1024


def heard_item(_seeds: Sequence[int], _jobs: int) -> bool:
    """Print the share of the messages that lcm-logger gets: full with a large buffer, thinned with a stock one."""
    passed = True
    for tap, buffer, min_share in (("full", "&recv_buf_size=2097152", None), ("thin", "", 0.99)):
        ours, theirs, wrong = _logged(tap, buffer)
        share = theirs / ours
        good = not wrong and (min_share is None or share >= min_share)
        passed &= good
        wanted = "" if min_share is None else f", at least {min_share}"
        mark = "ok  " if good else "MISS"
        say(f"{mark} --tap {tap}: lcm-logger got {theirs} of {ours} ({share:.4f}{wanted}), {wrong} differ")
    return passed


def _logged(tap: str, buffer: str) -> tuple[int, int, int]:
    """Return the numbers of messages in our log, in lcm-logger's, and of those in theirs that differ from ours."""
    with tempfile.TemporaryDirectory() as scratch:
        heard = Path(scratch) / "heard.lcmlog"
        logger = subprocess.Popen(
            [str(Path(lcm.LCM_BIN_DIR) / "lcm-logger"), "--quiet", "--lcm-url", GROUP + buffer, str(heard)]
        )
        time.sleep(1)
        command = [str(GRAPHNAV), "run", "corridor_ccw", "--seed", "3", "--pace", "1", "--tap", tap, "--until", "30"]
        command += ["--record", "all"]
        subprocess.run([*command, "--no-pictures", "-o", f"{scratch}/run"], check=True, capture_output=True)
        time.sleep(1)
        logger.terminate()
        logger.wait()
        with Recording(Path(scratch) / "run" / "run.lcmlog") as ours, Recording(heard) as theirs:
            sent = {(e.channel, e.data) for e in ours.events()}
            channels = {e.channel for e in ours.events()} - {"graphnav.about"}
            count = sum(ours.count(channel) for channel in channels)
            received = {(e.channel, e.data) for e in theirs.events() if e.channel in channels}
            wrong = len(received - sent) if tap == "full" else 0
    return count, len(received), wrong


def interrupt_item(_seeds: Sequence[int], _jobs: int) -> bool:
    """Press Ctrl-C at several moments of a drive; print how long it then takes to end, log and summary written."""
    took = []
    for after_s in (0.5, 1.0, 1.7, 2.9, 4.1):
        with tempfile.TemporaryDirectory() as scratch:
            command = [str(GRAPHNAV), "run", "corridor_ccw", "--pace", "2", "-o", f"{scratch}/run"]
            run = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            log = Path(scratch) / "run" / "run.lcmlog"
            while not log.exists():
                time.sleep(0.01)
            time.sleep(after_s)
            run.send_signal(signal.SIGINT)
            begin = time.monotonic()
            run.wait()
            took.append(time.monotonic() - begin)
            with Recording(log) as recording:
                is_complete = recording.truncated is None
            is_complete &= json.loads((Path(scratch) / "run" / "summary.json").read_text())["outcome"] == "stopped"
            if not is_complete:
                say(f"MISS Ctrl-C after {after_s} s: log or summary is not complete")
                return False
    good = max(took) <= 1.0
    mark = "ok  " if good else "MISS"
    say(f"{mark} Ctrl-C: ended within {max(took):.2f} s, {len(took)} times, logs and summaries complete")
    return good


def fresh_item(_seeds: Sequence[int], _jobs: int) -> bool:
    """Clone into an empty folder, and into one with a space in its path, and run the two lines of the README."""
    lines = re.findall(r"^python3 -m venv .*$", (ROOT / "README.md").read_text(), re.MULTILINE)
    passed = len(lines) == 2
    for name in ("plain", "with a space"):
        folder = Path(tempfile.mkdtemp()) / name
        subprocess.run(["git", "clone", "-q", str(ROOT), str(folder)], check=True)
        for line in lines:
            begin = time.monotonic()
            done = subprocess.run(["bash", "-c", line], cwd=folder, check=False, capture_output=True, text=True)
            passed &= done.returncode == 0
            failed = re.findall(r"^(?:FAILED|ERROR) .*$", done.stdout, re.MULTILINE)
            last = failed or done.stdout.strip().splitlines()[-1:]
            mark = "MISS" if done.returncode else "ok  "
            say(f"{mark} '{name}': {line[:60]}… {time.monotonic() - begin:.0f} s: {last}")
        runs = [sorted(p.name for p in run.iterdir()) for run in folder.glob("runs/*")]
        say(f"     left {runs}")
        passed &= bool(runs) and {"run.lcmlog", "graph.yaml", "summary.json", "map.png", "panels.png"} <= set(runs[0])
        shutil.rmtree(folder.parent)
    return passed


def bench_item(_seeds: Sequence[int], _jobs: int) -> bool:
    """Run tools/bench.py, which prints and judges its ratios."""
    return subprocess.run([sys.executable, str(ROOT / "tools" / "bench.py")], check=False).returncode == 0
