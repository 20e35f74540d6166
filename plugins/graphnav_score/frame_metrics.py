"""Metrics that depend on the frames that a run meets."""

from __future__ import annotations

from dataclasses import replace

from graphnav import Metric


def of_frames(*metrics: Metric) -> tuple[Metric, ...]:
    """Return metrics, each declared to depend on the frames that a run meets."""
    return tuple(replace(metric, of_frames=True) for metric in metrics)
