"""Acceptance of drives: every graph with every detector, the truth and the baseline, over the reporting seeds."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from acceptance.drives import Drives, drive_all, say
from graphnav.studies.ablation.results import wilson

DRAWS = 10_000
MIN_SHARE = 0.95
CORRIDORS = ("corridor_ccw", "corridor_cw")
ROWS: list[tuple[str, tuple[str, ...], str, float]] = [
    *(
        (graph, (f"plane=plane.{plane}",), "goal", min_share)
        for graph in CORRIDORS
        for plane, min_share in (("ica", 0.95), ("affine", 0.95), ("truth", 1.0))
    ),
    ("pillars", ("plane=plane.ica",), "goal", 0.85),
    ("pillars", ("plane=plane.truth",), "goal", 1.0),
    ("approach", (), "no contact", 1.0),
    *((graph, ("steer=steer.forward",), "failure", 0.95) for graph in (*CORRIDORS, "pillars", "approach")),
]


def drives_item(seeds: Sequence[int], jobs: int) -> bool:
    """Drive every row; print counts with 95 % intervals, failures by seed, and the sign of the steering."""
    passed = True
    for graph, sets, wanted, min_share in ROWS:
        drives = drive_all(graph, seeds, sets, jobs)
        count = succeeded(drives, wanted)
        low, high = wilson(count, len(seeds))
        good = count >= round(min_share * len(seeds))
        passed &= good
        say(
            f"{'ok  ' if good else 'MISS'} {graph:13} {' '.join(sets) or 'as it ships':20} {wanted}: {count} of "
            f"{len(seeds)} [{low:.2f}, {high:.2f}], at least {min_share:g}; {drives.outcomes()}"
        )
    return passed


def succeeded(drives: Drives, wanted: str) -> int:
    """Return the number of drives with the expected outcome of the row."""
    if wanted == "goal":
        return drives.ended("goal")
    if wanted == "no contact":
        return len(drives.seeds) - drives.ended("contact") - drives.ended("failed")
    return drives.ended("contact") + drives.ended("timeout")


def sign_item(seeds: Sequence[int], jobs: int) -> bool:
    """Pool the frames of the corridors whose obstacle is plainly on one side; print the share of right signs.

    The 95 % interval is bootstrapped over drives, because frames of one drive are not independent.
    """
    counts = []
    for graph in CORRIDORS:
        for summary in drive_all(graph, seeds, (), jobs).summaries:
            heading = summary["scores"]["heading"]
            counts.append((heading["frames"], heading["frames"] * heading.get("right_sign_ratio", 0.0)))
    frames, right = np.array(counts).T
    share = right.sum() / frames.sum()
    drawn = np.random.default_rng(0).integers(0, len(counts), (DRAWS, len(counts)))
    shares = right[drawn].sum(axis=1) / np.maximum(frames[drawn].sum(axis=1), 1)
    low, high = np.quantile(shares, [0.025, 0.975])
    good = bool(share >= MIN_SHARE)
    say(
        f"{'ok  ' if good else 'MISS'} right sign in {share:.3f} [{low:.3f}, {high:.3f}] of {frames.sum():.0f} frames "
        f"of {len(counts)} drives, {np.count_nonzero(frames)} of which have such frames; at least {MIN_SHARE}"
    )
    return good
