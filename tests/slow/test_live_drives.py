"""Live drives: the world in one process, the graph in another, in real time, paired with lockstep."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
from testbed.rig import Rig

from tests.targets import Targets

from .conftest import DriveAll

SLOW = Path(__file__).parent / "stages" / "slow_stage.py"
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


@pytest.mark.parametrize("condition", CONDITIONS)
def test_live(targets: Targets, drive_all: DriveAll, seeds: range, jobs: int, tmp_path: Path, condition: str) -> None:
    """Arrivals beside lockstep, overtaken messages, and the latency."""
    targets.say(f"lockstep: {drive_all('corridor_ccw', seeds, ()).outcomes()}")
    with ThreadPoolExecutor(jobs) as pool:
        drives = list(pool.map(lambda seed: _drive(condition, seed, tmp_path / f"{seed}"), seeds))
    goals = sum(outcome == "goal" for outcome, *_ in drives)
    failed = [f"{seed} {drive[0]}" for seed, drive in zip(seeds, drives, strict=True) if drive[0] != "goal"]
    latency = ", ".join(f"{what} {max(drive[1][what] for drive in drives):.1f}" for what in ("p50", "p99", "max"))
    overtaken = sum(drive[2] for drive in drives) / max(sum(drive[3] for drive in drives), 1)
    targets.check(
        f"{condition}: {goals} of {len(seeds)} arrive{' (' + ', '.join(failed) + ')' if failed else ''}; "
        f"{overtaken:.2f} of the frames overtaken; image to command, ms, the worst drive's: {latency}",
        good=goals >= MIN_SHARE * len(seeds),
    )


def _drive(condition: str, seed: int, folder: Path) -> tuple[str, dict[str, float], int, int]:
    """Return how a drive ended, its latencies in ms, and how many frames were overtaken of how many that came."""
    delay_s, options = CONDITIONS[condition]
    number = 1 + seed % 100 + 100 * (list(CONDITIONS).index(condition) % 2)
    with Rig(folder, number, seed) as rig:
        rig.fault({"delay_s": delay_s})
        rig.navigate(options=options)
        robot, graph = rig.finish()
    live = graph["live"]
    latency = {what: live["outputs"][0][f"latency_{what}_ms"] for what in ("p50", "p99", "max")}
    frames = next(one["accepted"] for one in live["inputs"] if one["name"] == "camera.image")
    return robot["outcome"], latency, sum(edge["overtaken"] for edge in live["edges"]), frames
