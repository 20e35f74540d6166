"""Floors that deceive the flow, at 1.0 m/s: how often the robot touches something without that the guard stopped it."""

from __future__ import annotations

from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
from testbed.drives import drive

from graphnav import GuardState, Recording, State
from graphnav.core.graph import shipped_folder
from tests.targets import Targets

GRAPH = "navigate/speed"
"""1.0 m/s and 20 images a second among pillars, whose contacts end the run."""
TILES = "maps/suite/tiles.yaml"
DRAWN_TILES = "tile_m: [0.1, 0.4]"
STOP_S = 1.0
"""A stop counts if the guard allowed no forward motion at some time within this before the contact."""
FLOORS: dict[str, tuple[str, ...]] = {
    **{f"tiles of {side_m:g} m": (f"tile_m: {side_m}",) for side_m in (0.05, 0.08, 0.1, 0.12, 0.15, 0.2, 0.3, 0.4)},
    "tiles of 0.1 m, light swings": ("tile_m: 0.1", "robot.light_swing_ratio=0.5", "robot.light_period_s=0.5"),
    "blank": ("robot.contrast_ratio=0",),
    "3 % of the contrast": ("robot.contrast_ratio=0.03",),
    "8 % of the contrast": ("robot.contrast_ratio=0.08",),
    "noise of 15 gray levels": ("robot.noise_sigma_gray=15",),
    "noise of 40 gray levels": ("robot.noise_sigma_gray=40",),
    "glossy": ("robot.lamp_ratio=0.5", "robot.glare_ratio=1"),
    "glossy, a lamp alone": ("robot.lamp_ratio=1", "robot.glare_ratio=4"),
    "stroboscopic, 10 Hz": ("robot.light_swing_ratio=0.9", "robot.light_period_s=0.1"),
    "stroboscopic, 7 Hz": ("robot.light_swing_ratio=0.9", "robot.light_period_s=0.143"),
    "stroboscopic, 3 Hz": ("robot.light_swing_ratio=0.9", "robot.light_period_s=0.333"),
    "exposure that jumps": ("robot.exposure_step_ratio=1", "robot.exposure_step_s=0.3"),
}


@pytest.mark.parametrize("floor", FLOORS)
def test_deceiving(targets: Targets, seeds: range, jobs: int, tmp_path: Path, floor: str) -> None:
    """Drive over a floor: outcomes, and contacts by whether the guard had stopped the robot before."""
    sets = [f"robot.map={_tiles(one, tmp_path)}" if one.startswith("tile_m") else one for one in FLOORS[floor]]
    with ThreadPoolExecutor(jobs) as pool:
        found = Counter(pool.map(lambda seed: _ending(seed, sets, tmp_path / f"{seed}"), seeds))
    text = ", ".join(f"{what} {n}" for what, n in sorted(found.items()))
    targets.check(f"{floor}: {text}", good=not found["contact without a stop"])


def _tiles(size: str, folder: Path) -> Path:
    """Write the map of tiles with tiles of one size."""
    text = (shipped_folder() / TILES).read_text()
    assert DRAWN_TILES in text
    path = folder / "tiles.yaml"
    path.write_text(text.replace(DRAWN_TILES, size))
    return path


def _ending(seed: int, sets: list[str], folder: Path) -> str:
    """Return how a drive ended."""
    outcome: str = drive(GRAPH, seed, [*sets, "run.record=small"], folder)["outcome"]
    if outcome != "contact":
        return outcome
    with Recording(folder / "run.lcmlog") as log:
        end = max(utime for utime, _, one in log.messages("robot.state") if isinstance(one, State))
        late = [
            one.may_advance
            for utime, _, one in log.messages("guard.state")
            if isinstance(one, GuardState) and utime > end - 1e6 * STOP_S
        ]
    return "contact without a stop" if all(late) else "contact after a stop"
