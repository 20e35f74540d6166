"""Acceptance of portable logs: the same bytes on this CPU and on models that QEMU emulates."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from itertools import product
from pathlib import Path

from acceptance.drives import say

MODELS = ("Haswell", "EPYC")
"""CPUs with AVX2 and FMA: the first of Intel, and one of AMD."""
GRAPHS = ("pillars", "navigate/pillars")
SEEDS = (3, 104)
_OLDEST_QEMU = 8
"""QEMU 7.2 computes AVX2's gathers wrongly: cv2.exp is off by up to a half."""


def portable_item(seeds: Sequence[int], jobs: int) -> bool:  # noqa: ARG001 - its seeds are its own
    """Print whether drives of two seconds are the same here and under QEMU."""
    qemu = shutil.which("qemu-x86_64")
    version = _version(qemu) if qemu else 0
    if version < _OLDEST_QEMU:
        say(f"MISS needs qemu-x86_64 of version {_OLDEST_QEMU} or newer on the path, found {version or 'none'}")
        return False
    passed = True
    with tempfile.TemporaryDirectory() as scratch:
        for graph, seed in product(GRAPHS, SEEDS):
            here = _log(Path(scratch) / f"{graph}-{seed}", graph, seed)
            for model in MODELS:
                there = _log(Path(scratch) / f"{graph}-{seed}-{model}", graph, seed, [str(qemu), "-cpu", model])
                same = bool(here) and here == there
                passed &= same
                mark, found = ("ok  ", "the same") if same else ("MISS", "another log")
                say(f"{mark} {graph}, seed {seed}, 2 s: {len(here)} bytes here, on {model} {found}")
    return passed


def _version(qemu: str) -> int:
    said = subprocess.run([qemu, "--version"], capture_output=True, text=True, check=False).stdout
    found = re.search(r"version (\d+)", said)
    return int(found[1]) if found else 0


def _log(folder: Path, graph: str, seed: int, on: Sequence[str] = ()) -> bytes:
    """Return the log of a drive, empty if it failed."""
    words = ["run", graph, "--portable", "--until", "2", "--seed", str(seed), "--no-tap", "--no-pictures"]
    line = [*on, sys.executable, "-m", "graphnav", *words, "-o", str(folder)]
    done = subprocess.run(line, capture_output=True, text=True, check=False)
    if done.returncode:
        say(done.stderr)
        return b""
    return (folder / "run.lcmlog").read_bytes()
