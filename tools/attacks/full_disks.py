"""Commands that write onto a disk that becomes full at a random moment."""

from __future__ import annotations

import json
import os
import random
import subprocess
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from attacks.own_process import COMMAND, outcome_of
from attacks.verdict import faults

_STUDY = ("--vary", "steer=steer.pca,steer.random", "--seeds", "0:2", "--set", "run.until_s=1", "-j", "1")
_KINDS = ("run", "record", "ablate", "export csv", "export mcap", "export images")
_MIN_BYTES = 4096
_FULL_BYTES = {"run": 5e6, "record": 5e6, "ablate": 3e5, "export csv": 2e6, "export mcap": 5e6, "export images": 3e5}
"""Sizes of a disk on which each command would have nearly enough room."""


def full_disks(scratch: Path, count: int, seed: int) -> Iterator[list[str]]:
    """Let commands write onto disks of random sizes; yield what is wrong with each.

    Raises
    ------
    OSError
        A small disk cannot be mounted: it needs root.
    """
    good = scratch / "good"
    outcome_of([*COMMAND, "run", "corridor_ccw", "--until", "2", "--no-tap", "--no-pictures", "-o", str(good)])
    url = f"udpm://239.255.95.{os.getpid() % 250 + 1}:{20_000 + os.getpid() % 10_000}?ttl=0"
    for number in range(count):
        kind = _KINDS[number % len(_KINDS)]
        size = random.Random(f"disks {seed + number}").uniform(0.0, 1.0) * _FULL_BYTES[kind]
        with (
            _disk(scratch / "disk", max(_MIN_BYTES, int(size))) as disk,
            _played(good, url if kind == "record" else ""),
        ):
            outcome = outcome_of(_words(kind, disk, good / "run.lcmlog", url))
            found = faults(outcome)
            if outcome.status and str(disk) not in outcome.output.replace("\n", ""):
                found.append("does not say where the disk is full")
            found += list(_left_wrong(disk))
        yield [f"{kind} on {int(size)} bytes: {fault}" for fault in found]


def _words(kind: str, disk: Path, log: Path, url: str) -> list[str]:
    command, _, to = kind.partition(" ")
    options: dict[str, Sequence[str]] = {
        "run": ("corridor_ccw", "--until", "2", "--no-tap", "-o", str(disk / "run")),
        "record": (url, "--for", "3", "-o", str(disk / "record.lcmlog")),
        "ablate": ("corridor_ccw", *_STUDY, "-o", str(disk / "study")),
        "export": (str(log), "--to", to, "-o", str(disk / f"out.{to}")),
    }
    return [*COMMAND, command, *options[command]]


def _left_wrong(disk: Path) -> Iterator[str]:
    """Yield what is wrong with the files that a command left."""
    for log in disk.rglob("*.lcmlog"):
        if log.stat().st_size:
            yield from (f"{log.name} left: {fault}" for fault in faults(outcome_of([*COMMAND, "info", str(log)])))
    for file in disk.rglob("*.json"):
        try:
            json.loads(file.read_bytes())
        except ValueError:
            yield f"leaves {file.relative_to(disk)} of {file.stat().st_size} bytes, which is not JSON"


@contextmanager
def _disk(place: Path, n_bytes: int) -> Iterator[Path]:
    """Mount a disk of this size."""
    place.mkdir(exist_ok=True)
    mount = ["mount", "-t", "tmpfs", "-o", f"size={n_bytes}", "tmpfs", str(place)]
    done = subprocess.run(mount, capture_output=True, text=True, check=False)
    if done.returncode:
        raise OSError(f"a small disk cannot be mounted: {done.stderr.strip()}")
    try:
        yield place
    finally:
        subprocess.run(["umount", "-l", str(place)], check=True)


@contextmanager
def _played(folder: Path, url: str) -> Iterator[None]:
    """Publish the messages of a run again and again while entered; without a URL do nothing."""
    if not url:
        yield
        return
    words = [*COMMAND, "play", str(folder), "--url", url, "--speed", "4", "--loop"]
    with subprocess.Popen(words, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL) as player:
        try:
            yield
        finally:
            player.terminate()
