"""The results of a study: one record a run, read from the summaries."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass


@dataclass(frozen=True)
class StageTime:
    """How long a stage's steps took in one run."""

    steps: int
    p50_ms: float
    p99_ms: float


@dataclass(frozen=True)
class Record:
    """What one run came to."""

    graph: str
    variant: str
    seed: int
    outcome: str
    failure: str
    frames: int
    sim_s: float
    figures: Mapping[str, float]
    """By ``stage.figure``; one that a run could not say is missing."""
    wall_s: float
    times: Mapping[str, StageTime]
    """By stage."""
    folder: str
    """Of the run, below the study's folder."""
