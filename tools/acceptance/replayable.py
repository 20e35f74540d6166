"""A replayable log is small, and a replay makes the full one of it."""

from __future__ import annotations

import subprocess
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from acceptance.drives import GRAPHNAV, say
from graphnav import Recording
from graphnav.core.catalog import Catalog
from graphnav.core.graph import load_graph, shipped_folder
from graphnav.core.record import ABOUT, LOG

DRIVES = (("corridor_ccw", 15.0), ("pillars", 15.0), ("approach", 10.0))
"""Graphs, and seconds of each."""
MAX_RATIO = 0.2
"""Of the sizes of the replayable and the full log."""
N_SEEDS = 3


def replayable_item(seeds: Sequence[int], _jobs: int) -> bool:
    """Record each drive in full and replayable; print the sizes, and whether the replay makes the full log."""
    passed = _readers_agree(seeds[0]) and _sizes(seeds[0])
    for graph, until_s in DRIVES:
        for seed in seeds[:N_SEEDS]:
            with tempfile.TemporaryDirectory() as scratch:
                found = _compared(graph, until_s, seed, Path(scratch))
            is_good = found.n_differing == 0 and found.ratio <= MAX_RATIO
            passed &= is_good
            say(
                f"{'ok  ' if is_good else 'MISS'} {graph}, seed {seed}, {until_s:g} s: {found.kept_bytes / 1e6:.1f} of "
                f"{found.full_bytes / 1e6:.1f} MB, ratio {found.ratio:.3f} (at most {MAX_RATIO}); "
                f"{found.n_differing} of {found.n_messages} messages differ from the full log"
            )
    return passed


def _sizes(seed: int) -> bool:
    """Print the sizes of the default and the full log of every graph that ships and runs in lockstep."""
    for path in sorted(shipped_folder().glob("*.yaml")):
        if load_graph(path, Catalog()).inputs:
            say(f"     {path.stem}: a live graph, which would send to other programs")
            continue
        with tempfile.TemporaryDirectory() as scratch:
            try:
                full, kept = (_drive(path.stem, 5.0, seed, record, Path(scratch)) for record in ("all", None))
            except subprocess.CalledProcessError:
                say(f"     {path.stem}: not a graph that runs alone in lockstep")
                continue
            sizes = [log.stat().st_size / 1e6 for log in (kept, full)]
            say(f"     {path.stem}, 5 s: {sizes[0]:.2f} of {sizes[1]:.2f} MB")
    return True


def _readers_agree(seed: int) -> bool:
    """Print whether commands write of a default log what they write of a full one."""
    passed = True
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        logs = [_drive("corridor_ccw", 15.0, seed, record, folder).parent for record in ("all", None)]
        for words in (["figure"], ["export", "--to", "mcap"], ["export", "--to", "csv"], ["spy", "--once"], ["hz"]):
            found = []
            for log in logs:
                out = folder / f"out-{len(list(folder.iterdir()))}"
                target = ["-o", str(out)] if words[0] in {"figure", "export"} else []
                done = subprocess.run([str(GRAPHNAV), *words, str(log), *target], check=True, capture_output=True)
                files = sorted(path for path in (out, *out.rglob("*")) if path.is_file())
                text = b"" if target else done.stdout.replace(str(log).encode(), b"")
                found.append((text, [path.read_bytes() for path in files]))
            passed &= found[0] == found[1]
            say(
                f"{'ok  ' if found[0] == found[1] else 'MISS'} {' '.join(words)}: of the default log as of the full one"
            )
    return passed


class _Compared(NamedTuple):
    """The sizes of the logs of one drive, and how many messages of the full one the replay does not make."""

    full_bytes: int
    kept_bytes: int
    n_messages: int
    n_differing: int

    @property
    def ratio(self) -> float:
        """The size of the replayable log as a share of the full one."""
        return self.kept_bytes / self.full_bytes


def _compared(graph: str, until_s: float, seed: int, folder: Path) -> _Compared:
    full, kept = (_drive(graph, until_s, seed, record, folder) for record in ("all", "replayable"))
    made = folder / "made.lcmlog"
    subprocess.run([str(GRAPHNAV), "replay", str(kept.parent), "-o", str(made)], check=True, capture_output=True)
    expected, found = _events(full), _events(made)
    n_differing = sum(one != other for one, other in zip(expected, found, strict=False))
    n_differing += abs(len(expected) - len(found))
    return _Compared(full.stat().st_size, kept.stat().st_size, len(expected), n_differing)


def _drive(graph: str, until_s: float, seed: int, record: str | None, folder: Path) -> Path:
    command = [str(GRAPHNAV), "run", graph, "--seed", str(seed), "--until", str(until_s), "--no-tap", "--no-pictures"]
    run = folder / (record or "default")
    command += [*(["--record", record] if record else []), "-o", str(run)]
    subprocess.run(command, check=True, capture_output=True, timeout=600)
    return run / LOG


def _events(log: Path) -> list[tuple[str, int, bytes]]:
    with Recording(log) as recording:
        return [(one.channel, one.utime, one.data) for one in recording.events() if one.channel != ABOUT]
