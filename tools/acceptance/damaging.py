"""Damaged logs: truncated at every byte, corrupted at random, recorded by a killed process or on a full disk."""

from __future__ import annotations

import os
import random
import tempfile
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

from acceptance.damage_trials import Damage, count_trials, try_commands
from acceptance.drives import say
from acceptance.recording_failures import full_disk, killed
from acceptance.small_logs import record_drive, record_tiny

_N_RANDOM = 200
_DRIVE_S = 1.0
_MAX_SMALL_BYTES = 6000
_MAX_SHOWN = 5


def damage_item(_seeds: Sequence[int], jobs: int) -> bool:
    """Print how each command comes out of damaged logs, how often, and what a killed and a full recording leave.

    The commands run within a few processes, not one each: a process for every byte would take hours.
    """
    drawn = random.Random(8)
    passed = True
    with tempfile.TemporaryDirectory() as scratch:
        for name in ("lockstep", "live"):
            data = record_tiny(Path(scratch) / name, is_live=name == "live").read_bytes()
            if len(data) > _MAX_SMALL_BYTES:
                raise RuntimeError(f"the small log has {len(data)} bytes, more than {_MAX_SMALL_BYTES}")
            what = f"a {name} log of {len(data)} bytes cut at every byte offset"
            passed &= _said(what, *count_trials(data, map(Damage, range(len(data))), jobs))
            what = f"the same log with one bit flipped, {_N_RANDOM} times"
            passed &= _said(what, *count_trials(data, _flips(drawn, data), jobs))
        data = record_drive(Path(scratch) / "drive", _DRIVE_S).read_bytes()
        large = f"a log of {len(data) / 1e6:.1f} MB"
        cuts = [Damage(drawn.randrange(len(data))) for _ in range(_N_RANDOM)]
        passed &= _said(f"{large} cut at {_N_RANDOM} random offsets", *count_trials(data, cuts, jobs))
        what = f"{large} with one bit flipped, {_N_RANDOM} times"
        passed &= _said(what, *count_trials(data, _flips(drawn, data), jobs))
        passed &= _without_permission(Path(scratch), data)
        for good, what in (*killed(Path(scratch), drawn), *full_disk(Path(scratch))):
            passed &= good
            say(f"{'ok  ' if good else 'MISS'} {what}")
    return passed


def _flips(drawn: random.Random, data: bytes) -> list[Damage]:
    return [Damage(len(data), drawn.randrange(8 * len(data))) for _ in range(_N_RANDOM)]


def _said(what: str, counts: Mapping[str, Counter[str]], wrong: Sequence[str]) -> bool:
    say(f"{'MISS' if wrong else 'ok  '} {what}: {_sum(counts.values())}")
    for command, came_out in counts.items():
        say(f"       {command:12} {_sum([came_out])}")
    for one in wrong[:_MAX_SHOWN]:
        say(f"       {one}")
    return not wrong


def _sum(counts: Iterable[Counter[str]]) -> str:
    total = sum(counts, Counter[str]())
    return ", ".join(f"{total[name]} {name}" for name in ("used", "refused", "complete", "silent", "crash"))


def _without_permission(folder: Path, data: bytes) -> bool:
    """Try every command on a log that may not be read."""
    if os.geteuid() == 0:
        say("     a log without permission: not tried, root may read everything")
        return True
    log = folder / "forbidden.lcmlog"
    log.write_bytes(data)
    log.chmod(0)
    trials = list(try_commands(log, folder, "udpm://239.255.92.251:9451?ttl=0"))
    good = all(trial.came_out == "refused" for trial in trials)
    refused = sum(trial.came_out == "refused" for trial in trials)
    say(f"{'ok  ' if good else 'MISS'} a log without permission: {refused} of {len(trials)} commands refuse it")
    return good
