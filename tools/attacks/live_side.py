"""A live robot, the graph that drives it, and what watches them, while spoiled messages arrive on their channels.

A spoiled log is played on their group, too.
"""

from __future__ import annotations

import os
import random
import re
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import IO, NamedTuple

from attacks.hostile_requests import answers, hostile_request
from attacks.own_process import COMMAND, TOOLS, outcome_of
from attacks.spoil import spoiled_bytes
from attacks.verdict import MAX_S, Outcome, faults

_LASTS_S = 10
_SENDS_S = 5
_START_S = 20.0
_N_REQUESTS = 40
_N_WATCHERS = 2
_WATCHERS = (
    ("hz",),
    ("bw",),
    ("echo", "CAMERA"),
    ("echo", "BASE_CMD", "--full"),
    ("top", "--once"),
    ("spy", "--json"),
    ("record",),
)
_SERVED = re.compile(r"http://\S+")


class _Program(NamedTuple):
    name: str
    process: subprocess.Popen[bytes]
    printed: IO[bytes]


def live_side(scratch: Path, count: int, seed: int) -> Iterator[list[str]]:
    """Attack ``count`` live runs; yield what is wrong with each."""
    good = scratch / "good"
    outcome_of([*COMMAND, "run", "corridor_ccw", "--until", "0.5", "--no-tap", "--no-pictures", "-o", str(good)])
    recorded = (good / "run.lcmlog").read_bytes()
    for number in range(count):
        folder = scratch / f"live-{number}"
        folder.mkdir()
        yield list(_attacked(folder, seed + number, recorded))


def _attacked(folder: Path, seed: int, recorded: bytes) -> Iterator[str]:
    """Yield what is wrong with a robot, its driver and their watchers after an attack."""
    drawn = random.Random(f"live {seed}")
    url = f"udpm://239.255.96.{os.getpid() % 250 + 1}:{20_000 + (os.getpid() + seed) % 10_000}?ttl=0"
    watchers = drawn.sample(_WATCHERS, _N_WATCHERS)
    programs = [
        _begun(folder, "base", "run", "robot_live", *_live_words(url, "base")),
        _begun(folder, "driver", "run", drawn.choice(("navigate_live", "navigate_robot")), *_live_words(url, "driver")),
        *(_begun(folder, words[0], *words, *_watch_words(words[0], url)) for words in watchers),
    ]
    (folder / "played.lcmlog").write_bytes(spoiled_bytes(recorded, drawn))
    play = _begun(folder, "play", "play", "played.lcmlog", "--loop", "--url", url)
    view = _begun(folder, "view", "view", url, "--port", "0")
    place = _place_of(view)
    sender = [sys.executable, "-m", "attacks.hostile_sender", url, str(_SENDS_S), str(seed)]
    with subprocess.Popen(sender, env=os.environ | {"PYTHONPATH": str(TOOLS)}, stdout=subprocess.DEVNULL) as process:
        for _ in range(_N_REQUESTS):
            hostile_request(place, drawn)
        process.wait()
    if not answers(place):
        yield "view: does not answer any more"
    for program in (play, view):
        program.process.send_signal(signal.SIGINT)
    for program in (*programs, play, view):
        yield from (f"{program.name}: {fault}" for fault in faults(_end_of(program)))
    replayed = outcome_of([*COMMAND, "replay", "driver"], folder=folder)
    yield from (f"replay: {fault}" for fault in faults(replayed))
    if replayed.status:
        yield f"the driver's log is not replayed: {replayed.output.strip()[-200:]}"


def _live_words(url: str, name: str) -> tuple[str, ...]:
    kept = ("--set", "run.record=replayable")
    return ("--live", "--url", url, "--until", str(_LASTS_S), "--no-tap", "--no-pictures", *kept, "-o", name)


def _watch_words(command: str, url: str) -> tuple[str, ...]:
    seconds = ("--for", str(_LASTS_S - 3))
    return (url, *seconds, "-o", "watched.lcmlog") if command == "record" else (url, *seconds)


def _begun(folder: Path, name: str, *words: str) -> _Program:
    printed = (folder / f"{name}.txt").open("w+b")
    process = subprocess.Popen(
        [*COMMAND, *words], stdin=subprocess.DEVNULL, stdout=printed, stderr=subprocess.STDOUT, cwd=folder
    )
    return _Program(name, process, printed)


def _place_of(view: _Program) -> str:
    """Return the URL that a server prints."""
    end_s = time.monotonic() + _START_S
    while time.monotonic() < end_s and view.process.poll() is None:
        if found := _SERVED.search(Path(view.printed.name).read_text(errors="replace")):
            return found[0]
        time.sleep(0.05)
    return "http://127.0.0.1:1/"


def _end_of(program: _Program) -> Outcome:
    """Wait for the end of a program that lasts for a time; how long it took is not judged."""
    try:
        status: int | None = program.process.wait(_LASTS_S + 2 * MAX_S)
    except subprocess.TimeoutExpired:
        program.process.kill()
        program.process.wait()
        status = None
    program.printed.seek(0)
    with program.printed:
        output = program.printed.read().decode("utf-8", "replace")
    return Outcome(0 if status == 130 else status, output, 0.0, 0.0)
