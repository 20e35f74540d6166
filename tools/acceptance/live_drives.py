"""Live drives: the world in one process, the graph in another, in real time, paired with lockstep."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from acceptance.drives import drive_all, say
from acceptance.rig import Rig

SLOW = Path(__file__).with_name("slow_stage.py")
MIN_SHARE = 0.9
OVERTAKING = (
    "--plugin",
    str(SLOW),
    *("--set", "slow+=late.slow"),
    *("--set", "slow.in.image=camera.image"),
    *("--set", "slow.busy_ms=200"),
    *("--set", "flow.in.image=slow.image"),
)
CONDITIONS: dict[str, tuple[float, Sequence[str]]] = {
    "no added delay": (0.0, ()),
    "50 ms delay": (0.05, ()),
    "150 ms delay": (0.15, ()),
    "every second frame overtaken": (0.0, OVERTAKING),
}


def live_item(seeds: Sequence[int], jobs: int) -> bool:
    """Drive every condition over the seeds beside lockstep; print what arrived, what was overtaken and the latency."""
    lockstep = drive_all("corridor_ccw", seeds, (), jobs)
    say(f"     lockstep: {lockstep.outcomes()}")
    passed = True
    for name in CONDITIONS:
        with ThreadPoolExecutor(jobs) as pool:
            drives = list(pool.map(lambda seed, name=name: _drive(name, seed), seeds))
        goals = sum(outcome == "goal" for outcome, *_ in drives)
        passed &= goals >= MIN_SHARE * len(seeds)
        failed = [f"{seed} {drive[0]}" for seed, drive in zip(seeds, drives, strict=True) if drive[0] != "goal"]
        latency = ", ".join(f"{what} {max(drive[1][what] for drive in drives):.1f}" for what in ("p50", "p99", "max"))
        overtaken = sum(drive[2] for drive in drives) / max(sum(drive[3] for drive in drives), 1)
        mark = "ok  " if goals >= MIN_SHARE * len(seeds) else "MISS"
        say(
            f"{mark} {name}: {goals} of {len(seeds)} arrive{' (' + ', '.join(failed) + ')' if failed else ''}; "
            f"{overtaken:.2f} of the frames overtaken; image to command, ms, the worst drive's: {latency}"
        )
    return passed


def _drive(condition: str, seed: int) -> tuple[str, dict[str, float], int, int]:
    """Return how a drive ended, its latencies in ms, and how many frames were overtaken of how many that came."""
    delay_s, options = CONDITIONS[condition]
    number = 1 + seed % 100 + 100 * (list(CONDITIONS).index(condition) % 2)
    with tempfile.TemporaryDirectory() as scratch, Rig(Path(scratch), number, seed) as rig:
        rig.fault({"delay_s": delay_s})
        rig.navigate(options=options)
        robot, graph = rig.finish()
        live = graph["live"]
    latency = {what: live["outputs"][0][f"latency_{what}_ms"] for what in ("p50", "p99", "max")}
    frames = next(one["accepted"] for one in live["inputs"] if one["name"] == "camera.image")
    return robot["outcome"], latency, sum(edge["overtaken"] for edge in live["edges"]), frames
