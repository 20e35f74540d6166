"""Derive a seed for every stage, so that swapping another stage does not change it."""

from __future__ import annotations

import hashlib


def seed_of(run_seed: int, stage: str) -> int:
    """Return the seed of a stage, below 2**32, from the run's seed and the stage's name."""
    return int.from_bytes(hashlib.sha256(f"{run_seed}/{stage}".encode()).digest()[:4], "big")
