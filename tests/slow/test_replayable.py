"""A replayable log is small, and a replay makes the full one of it."""

from __future__ import annotations

import subprocess
from pathlib import Path
from typing import NamedTuple

import pytest
from testbed.drives import GRAPHNAV

from graphnav import Recording
from graphnav.core.catalog import Catalog
from graphnav.core.graph import load_graph, shipped_folder
from graphnav.core.messages import About
from graphnav.core.run_folder import RunFolder
from tests.targets import Targets

DRIVES = (("corridor_ccw", 15.0), ("pillars", 15.0), ("approach", 10.0))
"""Graphs, and seconds of each."""
MAX_RATIO = 0.2
"""Of the sizes of the replayable and the full log."""


@pytest.mark.parametrize("place", range(3))
@pytest.mark.parametrize(("graph", "until_s"), DRIVES)
def test_replayable(targets: Targets, seeds: range, tmp_path: Path, graph: str, until_s: float, place: int) -> None:
    """The replay of a replayable log makes the full one, which is much larger."""
    seed = seeds[place % len(seeds)]
    found = _compared(graph, until_s, seed, tmp_path)
    targets.check(
        f"{graph}, seed {seed}, {until_s:g} s: {found.kept_bytes / 1e6:.1f} of {found.full_bytes / 1e6:.1f} MB, ratio "
        f"{found.ratio:.3f} (at most {MAX_RATIO}); {found.n_differing} of {found.n_messages} messages differ from the "
        "full log",
        good=found.n_differing == 0 and found.ratio <= MAX_RATIO,
    )


@pytest.mark.parametrize("name", sorted(path.stem for path in shipped_folder().glob("*.yaml")))
def test_replayable_sizes(targets: Targets, seeds: range, tmp_path: Path, name: str) -> None:
    """The sizes of the default and the full log of a graph that ships and runs alone in lockstep."""
    if load_graph(name, Catalog()).inputs:
        pytest.skip("a live graph, which would send to other programs")
    try:
        full, kept = (_drive(name, 5.0, seeds[0], record, tmp_path) for record in ("all", None))
    except subprocess.CalledProcessError:
        pytest.skip("not a graph that runs alone in lockstep")
    targets.say(f"{name}, 5 s: {kept.stat().st_size / 1e6:.2f} of {full.stat().st_size / 1e6:.2f} MB")


def test_replayable_readers_agree(targets: Targets, seeds: range, tmp_path: Path) -> None:
    """Commands write of a default log what they write of a full one."""
    logs = [_drive("corridor_ccw", 15.0, seeds[0], record, tmp_path).parent for record in ("all", None)]
    for words in (["figure"], ["export", "--to", "mcap"], ["export", "--to", "csv"], ["spy", "--once"], ["hz"]):
        found = []
        for log in logs:
            out = tmp_path / f"out-{len(list(tmp_path.iterdir()))}"
            target = ["-o", str(out)] if words[0] in {"figure", "export"} else []
            done = subprocess.run([str(GRAPHNAV), *words, str(log), *target], check=True, capture_output=True)
            files = sorted(path for path in (out, *out.rglob("*")) if path.is_file())
            text = b"" if target else done.stdout.replace(str(log).encode(), b"")
            found.append((text, [path.read_bytes() for path in files]))
        targets.check(f"{' '.join(words)}: of the default log as of the full one", good=found[0] == found[1])


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
    return run / RunFolder.LOG


def _events(log: Path) -> list[tuple[str, int, bytes]]:
    with Recording(log) as recording:
        return [(one.channel, one.utime, one.data) for one in recording.events() if one.channel != About.CHANNEL]
