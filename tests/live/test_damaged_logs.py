"""Damaged logs of live runs: intact parts replay and are written again, losses are reported, nothing crashes."""

from __future__ import annotations

import random
from collections.abc import Callable
from pathlib import Path

from graphnav import Recording
from graphnav.core.errors import GraphnavError
from graphnav.replay.comparison.result import ReplayResult

Again = Callable[..., ReplayResult]

N_CUTS, N_FLIPS = 24, 36
TWIN = ("twin+=probe.pass", "twin.in.command=both.twist", "twin.in.image=camera.image", "twin.every_ms=10")


def _is_complete(log: Path) -> bool:
    with Recording(log) as recording:
        return recording.truncated is None and not recording.damaged


def test_a_log_cut_anywhere_has_no_differences_and_is_written_without_damage(
    again: Again, log: Path, tmp_path: Path
) -> None:
    data = log.read_bytes()
    cut, out = tmp_path / "cut.lcmlog", tmp_path / "out.lcmlog"
    drawn = random.Random(4)
    done = []
    for size in sorted(drawn.randrange(len(data)) for _ in range(N_CUTS)):
        cut.write_bytes(data[:size])
        out.unlink(missing_ok=True)
        try:
            result = again(cut, out=out)
        except GraphnavError:
            done.append(0)
            continue
        assert result.is_equal, size
        assert result.lost or _is_complete(cut), size
        assert _is_complete(out), size
        back = again(out)
        assert (back.is_equal, back.lost, back.n_ticks) == (True, (), result.n_ticks), size
        done.append(result.n_ticks)
    assert done == sorted(done)
    assert done[-1] > 10


def test_flipped_bits_never_crash_and_leave_logs_without_damage(again: Again, log: Path, tmp_path: Path) -> None:
    data = log.read_bytes()
    spoiled, out = tmp_path / "spoiled.lcmlog", tmp_path / "out.lcmlog"
    drawn = random.Random(5)
    n_replayed = 0
    for number in range(N_FLIPS):
        bad = bytearray(data)
        bad[drawn.randrange(len(bad))] ^= 1 << drawn.randrange(8)
        spoiled.write_bytes(bad)
        out.unlink(missing_ok=True)
        try:
            result = again(spoiled, *(TWIN if number % 3 == 0 else ()), out=out)
        except GraphnavError:
            continue
        n_replayed += 1
        assert result.n_ticks < 10_000
        assert _is_complete(out)
    assert n_replayed > N_FLIPS // 2
