"""The intact messages of a damaged log are exported, and losses are reported."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest

from graphnav import Twist
from graphnav.core.cli import main
from graphnav.core.codec import encode
from graphnav.core.record import LogWriter
from graphnav.watch.export import FORMATS

KINDS = sorted(FORMATS)
N_TWISTS = 3


@pytest.fixture
def small(tmp_path: Path) -> bytes:
    """Return a log of three commands."""
    with LogWriter(tmp_path / "small") as log:
        for k in range(N_TWISTS):
            log.write("control.twist", k, encode(Twist(v_mps=0.0, omega_radps=1.0), k, k))
    return (tmp_path / "small").read_bytes()


def test_a_log_cut_anywhere_gives_what_is_before(
    small: bytes, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    each = len(small) // N_TWISTS
    for n_bytes in (*range(0, len(small), 3), len(small)):
        (tmp_path / "cut").write_bytes(small[:n_bytes])
        words = ["export", str(tmp_path / "cut"), "--to", "csv", "-o", str(tmp_path / "t.csv"), "--force"]
        status = main([*words, "--channel", "control.twist"])
        said = capsys.readouterr()
        assert "Traceback" not in said.err
        if n_bytes < each:
            assert status != 0
            assert said.err
            continue
        assert status == 0
        assert len((tmp_path / "t.csv").read_text().splitlines()) == 1 + n_bytes // each
        assert bool(said.err) == bool(n_bytes % each)


@pytest.mark.parametrize("kind", KINDS)
def test_flipped_bits_in_messages_cost_those_messages(
    drive: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], kind: str
) -> None:
    damaged = bytearray((drive / "run.lcmlog").read_bytes())
    rng = np.random.default_rng(5)
    for at in _inside(bytes(damaged), rng, 60):
        damaged[at] ^= 1 << int(rng.integers(8))
    (tmp_path / "log").write_bytes(damaged)
    assert main(["export", str(tmp_path / "log"), "--to", kind, "-o", str(tmp_path / "out")]) == 0
    assert (tmp_path / "out").exists()
    assert "Traceback" not in capsys.readouterr().err


@pytest.mark.parametrize("kind", ["mcap", "mp4"])
def test_a_damaged_description_costs_nothing_else(drive: Path, tmp_path: Path, kind: str) -> None:
    log = (drive / "run.lcmlog").read_bytes()
    (tmp_path / "log").write_bytes(log.replace(b"stages:", b"st\x00ges:", 1))
    assert main(["export", str(tmp_path / "log"), "--to", kind, "-o", str(tmp_path / "out")]) == 0
    assert main(["figure", str(tmp_path / "log"), "--every", "1s", "-o", str(tmp_path)]) == 0


@pytest.mark.parametrize("kind", KINDS)
def test_a_drive_that_is_cut_short_is_exported(
    drive: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], kind: str
) -> None:
    complete = (drive / "run.lcmlog").read_bytes()
    (tmp_path / "log").write_bytes(complete[: len(complete) * 2 // 3])
    assert main(["export", str(tmp_path / "log"), "--to", kind, "-o", str(tmp_path / "out")]) == 0
    assert "is truncated; left out" in capsys.readouterr().err


@pytest.mark.parametrize("kind", KINDS)
def test_a_log_of_unknown_types_is_refused_by_name(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], kind: str
) -> None:
    with LogWriter(tmp_path / "log") as log:
        log.write("\x1b[31mEVIL", 0, bytes(20))
    assert main(["export", str(tmp_path / "log"), "--to", kind, "-o", str(tmp_path / "out")]) == 2
    said = capsys.readouterr().err
    assert "\x1b" not in said
    assert not (tmp_path / "out").exists()


def test_what_is_not_installed_is_told(drive: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    shutil.copy(drive / "run.lcmlog", tmp_path / "log")
    with LogWriter(tmp_path / "foreign") as log:
        log.write("\x1b[31mEVIL", 0, bytes(20))
    with (tmp_path / "log").open("ab") as file:
        file.write((tmp_path / "foreign").read_bytes())
    assert main(["export", str(tmp_path / "log"), "--to", "csv", "-o", str(tmp_path / "out")]) == 0
    assert capsys.readouterr().err == "channel '\\x1b[31mEVIL': its type is not installed; 1 message left out\n"


def _inside(log: bytes, rng: np.random.Generator, count: int) -> list[int]:
    """Return offsets within the data of events behind the first."""
    import struct

    spans, at = [], 0
    while at < len(log):
        _, _, _, n_channel, n_data = struct.unpack_from(">Iqqii", log, at)
        start = at + 28 + n_channel
        spans.append((start, start + n_data))
        at = start + n_data
    chosen = rng.choice(len(spans) - 1, count, replace=False) + 1
    return [int(rng.integers(*spans[index])) for index in chosen]
