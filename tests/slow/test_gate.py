"""`navigate` against the paper's chain, world by world on the same seeds: it may not lose what the chain has."""

from __future__ import annotations

import numpy as np
import pytest

from graphnav.core.graph import shipped_folder
from graphnav.studies.ablation.results.statistics import difference_interval
from tests.targets import Targets

from .conftest import DriveAll

MIN_DIFFERENCE = -0.1
"""Of the shares that arrive: the interval's lower bound. Without a loss it takes 26 seeds."""
CHAIN = {path.stem for path in (shipped_folder() / "suite").glob("*.yaml")}
WORLDS = sorted(CHAIN & {path.stem for path in (shipped_folder() / "navigate").glob("*.yaml")})


@pytest.mark.parametrize("world", WORLDS)
def test_gate(targets: Targets, drive_all: DriveAll, seeds: range, world: str) -> None:
    """The difference of the shares that arrive, with its interval."""
    navigate, chain = (drive_all(f"{family}/{world}", tuple(seeds), ()) for family in ("navigate", "suite"))
    arrived, base = (
        np.array([one["scores"]["drive"]["success"] for one in drives.summaries], float) for drives in (navigate, chain)
    )
    interval = difference_interval(arrived, base, is_binary=True)
    text = f"{world}: navigate {navigate.outcomes()}; chain {chain.outcomes()}"
    text += f"; difference {arrived.mean() - base.mean():+.2f} [{interval.low:+.2f}, {interval.high:+.2f}]"
    targets.check(text, good=interval.low > MIN_DIFFERENCE)
