"""Damaged logs: truncated at every byte, corrupted at random, or not readable: how each command comes out of them.

The commands run within a few processes, not one each: a process for every byte would take hours.
"""

from __future__ import annotations

import os
import random
from collections import Counter
from collections.abc import Iterable
from pathlib import Path

import pytest

from tests.targets import Targets

from .damage_trials import Damage, count_trials, try_commands
from .small_logs import record_drive, record_tiny

_N_RANDOM = 200
_DRIVE_S = 1.0
_MAX_SMALL_BYTES = 6000
_MAX_SHOWN = 5


@pytest.mark.parametrize("name", ["lockstep", "live"])
def test_damage_of_a_small_log(targets: Targets, jobs: int, tmp_path: Path, name: str) -> None:
    data = record_tiny(tmp_path / name, is_live=name == "live").read_bytes()
    assert len(data) <= _MAX_SMALL_BYTES
    what = f"a {name} log of {len(data)} bytes"
    _try(targets, f"{what} cut at every byte offset", data, map(Damage, range(len(data))), jobs)
    _try(targets, f"{what} with one bit flipped, {_N_RANDOM} times", data, _flips(random.Random(8), data), jobs)


def test_damage_of_a_drive(targets: Targets, jobs: int, tmp_path: Path) -> None:
    data = record_drive(tmp_path / "drive", _DRIVE_S).read_bytes()
    drawn, what = random.Random(8), f"a log of {len(data) / 1e6:.1f} MB"
    cuts = [Damage(drawn.randrange(len(data))) for _ in range(_N_RANDOM)]
    _try(targets, f"{what} cut at {_N_RANDOM} random offsets", data, cuts, jobs)
    _try(targets, f"{what} with one bit flipped, {_N_RANDOM} times", data, _flips(drawn, data), jobs)


@pytest.mark.skipif(os.geteuid() == 0, reason="root may read everything")
def test_damage_a_log_without_permission(targets: Targets, tmp_path: Path) -> None:
    log = record_drive(tmp_path / "drive", _DRIVE_S)
    log.chmod(0)
    trials = list(try_commands(log, tmp_path, "udpm://239.255.92.251:9451?ttl=0"))
    refused = sum(trial.came_out == "refused" for trial in trials)
    text = f"a log without permission: {refused} of {len(trials)} commands refuse it"
    targets.check(text, good=refused == len(trials))


def _flips(drawn: random.Random, data: bytes) -> list[Damage]:
    return [Damage(len(data), drawn.randrange(8 * len(data))) for _ in range(_N_RANDOM)]


def _try(targets: Targets, what: str, data: bytes, damages: Iterable[Damage], jobs: int) -> None:
    counts, wrong = count_trials(data, damages, jobs)
    targets.check(f"{what}: {_sum(counts.values())}", good=not wrong)
    for command, came_out in counts.items():
        targets.say(f"  {command:12} {_sum([came_out])}")
    for one in wrong[:_MAX_SHOWN]:
        targets.say(f"  {one}")


def _sum(counts: Iterable[Counter[str]]) -> str:
    total = sum(counts, Counter[str]())
    return ", ".join(f"{total[name]} {name}" for name in ("used", "refused", "complete", "silent", "crash"))
