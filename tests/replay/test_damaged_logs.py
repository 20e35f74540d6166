"""Damaged logs: what is complete is used, what is lost is told, nothing crashes."""

from __future__ import annotations

import random
from collections.abc import Callable
from pathlib import Path

import pytest

from graphnav.core.cli import main
from graphnav.core.errors import GraphnavError, UserError
from graphnav.core.record import Recording
from graphnav.replay.comparison.result import ReplayResult
from graphnav.replay.log.log_graph import LogGraph
from graphnav.replay.replay import ReplayOptions, replay

STAGES = Path(__file__).parent / "stages.py"
Record = Callable[..., Path]
Again = Callable[..., ReplayResult]
Made = Callable[..., LogGraph]
SHORT = """
run: {until_s: 0.3, seed: 5}
stages:
  robot:  {use: again.robot, with: {rows: 1}, in: {command: gather.twist}}
  mean:   {use: again.mean, in: {image: robot.image}}
  gather: {use: again.gather, in: {twist: mean.twist, odometry: robot.odometry, goal: robot.goal}}
"""


@pytest.fixture
def damaged(record: Record, tmp_path: Path) -> tuple[bytes, Path]:
    """Return the bytes of a short log, and where to put what is left of them."""
    log = record(SHORT)
    return log.read_bytes(), tmp_path / "left.lcmlog"


def test_a_log_cut_at_any_byte_has_no_differences(damaged: tuple[bytes, Path], made: Made) -> None:
    data, path = damaged
    path.write_bytes(data)
    complete = made(path)
    begin = data.index(bytes.fromhex("eda1da01"), 4)
    n_compared = []
    for size in range(begin, len(data), 3):
        path.write_bytes(data[:size])
        try:
            with Recording(path) as recording:
                result = replay(recording, complete, ReplayOptions())
        except UserError:
            n_compared.append(0)
            continue
        assert result.is_equal, size
        n_compared.append(sum(channel.n_compared for channel in result.channels.values()))
        assert result.lost or data[size : size + 4] == bytes.fromhex("eda1da01")
    assert n_compared == sorted(n_compared)
    assert n_compared[-1] >= 6


def test_flipped_bits_never_crash(damaged: tuple[bytes, Path], again: Again) -> None:
    data, path = damaged
    drawn = random.Random(7)
    told = 0
    for _ in range(60):
        place, bit = drawn.randrange(len(data)), drawn.randrange(8)
        path.write_bytes(data[:place] + bytes([data[place] ^ 1 << bit]) + data[place + 1 :])
        try:
            result = again(path)
        except GraphnavError:
            told += 1
            continue
        told += bool(result.lost) or not result.is_equal
    assert told > 20


def test_the_command_ends_without_a_traceback(damaged: tuple[bytes, Path], capsys: pytest.CaptureFixture[str]) -> None:
    data, path = damaged
    drawn = random.Random(8)
    for _ in range(30):
        bad = bytearray(data[: drawn.randrange(1, len(data))] if drawn.random() < 0.3 else data)
        for _ in range(drawn.randrange(1, 20)):
            bad[drawn.randrange(len(bad))] = drawn.randrange(256)
        path.write_bytes(bad)
        assert main(["replay", str(path), "--plugin", str(STAGES)]) in (0, 1, 2)
        said = capsys.readouterr()
        assert "Traceback" not in said.err
        assert all(char.isprintable() or char == "\n" for char in said.out + said.err)
