"""Portable logs: the same bytes on this CPU and on models that QEMU emulates."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from collections.abc import Sequence
from itertools import product
from pathlib import Path

import pytest

from tests.targets import Targets

MODELS = ("Haswell", "EPYC")
"""CPUs with AVX2 and FMA: the first of Intel, and one of AMD."""
GRAPHS = ("pillars", "navigate/pillars")
SEEDS = (3, 104)
_OLDEST_QEMU = 8
"""QEMU 7.2 computes AVX2's gathers wrongly: cv2.exp is off by up to a half."""


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize(("graph", "seed"), list(product(GRAPHS, SEEDS)))
def test_portable(targets: Targets, tmp_path: Path, graph: str, seed: int, model: str) -> None:
    """Drives of two seconds are the same here and under QEMU."""
    qemu = shutil.which("qemu-x86_64")
    version = _version(qemu) if qemu else 0
    if version < _OLDEST_QEMU:
        pytest.skip(f"needs qemu-x86_64 of version {_OLDEST_QEMU} or newer on the path, found {version or 'none'}")
    here = _log(tmp_path / "here", graph, seed)
    there = _log(tmp_path / "there", graph, seed, [str(qemu), "-cpu", model])
    found = "the same" if here == there else "another log"
    targets.check(f"{graph}, seed {seed}, 2 s: {len(here)} bytes here, on {model} {found}", good=here == there)


def _version(qemu: str) -> int:
    said = subprocess.run([qemu, "--version"], capture_output=True, text=True, check=False).stdout
    found = re.search(r"version (\d+)", said)
    return int(found[1]) if found else 0


def _log(folder: Path, graph: str, seed: int, on: Sequence[str] = ()) -> bytes:
    """Return the log of a drive."""
    words = ["run", graph, "--portable", "--until", "2", "--seed", str(seed), "--no-tap", "--no-pictures"]
    line = [*on, sys.executable, "-m", "graphnav", *words, "-o", str(folder)]
    done = subprocess.run(line, capture_output=True, text=True, check=False)
    assert not done.returncode, done.stderr
    return (folder / "run.lcmlog").read_bytes()
