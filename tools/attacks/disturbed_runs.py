"""Runs that are disturbed from outside: by hostile messages on their group, and by signals at random moments."""

from __future__ import annotations

import os
import random
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

from attacks.own_process import COMMAND, outcome_of
from attacks.own_time import OwnTime
from attacks.verdict import MAX_S, Outcome, faults

_FLOOD = Path(__file__).resolve().parents[1] / "flood_spy.py"
_UNTIL_S = "3"
_SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
_LATEST_S = 3.0
_LOOK_S = 0.5
_ENDED = {0, 1, 130}
"""Of a run that was told to stop: finished before, failed, stopped."""


def hostile_messages(scratch: Path, count: int) -> Iterator[list[str]]:
    """Run a graph again and again while a sender floods its group; yield what is wrong with each run."""
    url = f"udpm://239.255.94.{os.getpid() % 250 + 1}:{20_000 + os.getpid() % 10_000}?ttl=0"
    around = os.environ | {"LCM_DEFAULT_URL": url}
    outcome_of(_words(scratch / "alone"), environment=around)
    alone = (scratch / "alone" / "run.lcmlog").read_bytes()
    flood = [sys.executable, str(_FLOOD), "--send", url, "--count", str(count)]
    with subprocess.Popen(flood, stdout=subprocess.DEVNULL) as sender:
        number = 0
        while sender.poll() is None or not number:
            folder = scratch / f"disturbed-{number}"
            outcome = outcome_of(_words(folder), environment=around)
            found = faults(outcome)
            log = folder / "run.lcmlog"
            if outcome.status == 0 and log.read_bytes() != alone:
                found.append("makes another log than undisturbed")
            yield found
            log.unlink(missing_ok=True)
            number += 1


def signals(scratch: Path, count: int, seed: int) -> Iterator[list[str]]:
    """Send a signal to a run at a random moment, twice now and then; yield what is wrong with each."""
    for number in range(count):
        drawn = random.Random(f"signals {seed + number}")
        sent, folder = drawn.choice(_SIGNALS), scratch / f"stopped-{number}"
        process = subprocess.Popen(
            _words(folder, "60"),
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
        )
        own_time = OwnTime(process.pid)
        time.sleep(drawn.uniform(0.0, _LATEST_S))
        n_sent = drawn.choice((1, 1, 2))
        for _ in range(n_sent):
            process.send_signal(sent)
            time.sleep(0.02)
        output = _output_of(process, own_time, own_time.elapsed_s() + MAX_S)
        if output is None:
            yield [f"{sent.name} does not end it"]
            continue
        status = process.returncode
        outcome = Outcome(0 if status in _ENDED else status, output, own_time.elapsed_s(), 0.0)
        # Before Python handles signals the system ends the process, and a second one ends it at once.
        is_at_once = status == -sent and (n_sent > 1 or not folder.exists())
        found = [fault for fault in faults(outcome) if not is_at_once or fault.startswith("prints")]
        log, summary = folder / "run.lcmlog", folder / "summary.json"
        if log.exists():
            found += [f"its log: {fault}" for fault in faults(outcome_of([*COMMAND, "info", str(log)]))]
            if n_sent == 1 and not summary.exists():  # a second one may break off the start of the run
                found.append("leaves a log without a summary")
            log.unlink()
        if summary.exists() and not summary.stat().st_size:
            found.append("leaves an empty summary")
        yield [f"{sent.name}: {fault}" for fault in found]


def _output_of(process: subprocess.Popen[bytes], own_time: OwnTime, end_s: float) -> str | None:
    """Return what a process has printed when it ended; None, and kill it, if it has not at a time of its own."""
    while own_time.elapsed_s() < end_s:
        with suppress(subprocess.TimeoutExpired):
            return process.communicate(timeout=_LOOK_S)[0].decode("utf-8", "replace")
    process.kill()
    process.communicate()
    return None


def _words(folder: Path, until_s: str = _UNTIL_S) -> list[str]:
    return [*COMMAND, "run", "corridor_ccw", "--until", until_s, "--no-pictures", "-o", str(folder)]
