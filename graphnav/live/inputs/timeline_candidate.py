"""A timeline of stamps that differs from the accepted one and may replace it."""

from __future__ import annotations


class Candidate:
    """Consecutive messages that agree with each other: their stamps advance as much as their arrivals."""

    def __init__(self, stamp: int, arrival_s: float, delay_s: float) -> None:
        self.count = 1
        self.stamp = stamp
        self.arrival_s = arrival_s
        self.min_delay_s = delay_s

    def add(self, stamp: int, arrival_s: float, delay_s: float, tolerance_s: float) -> None:
        """Add the next message; one that does not agree within ``tolerance_s`` restarts the timeline."""
        advance_s = (stamp - self.stamp) / 1e6
        if advance_s > 0 and abs(advance_s - (arrival_s - self.arrival_s)) <= tolerance_s:
            self.count += 1
            self.min_delay_s = min(self.min_delay_s, delay_s)
        else:
            self.count, self.min_delay_s = 1, delay_s
        self.stamp, self.arrival_s = stamp, arrival_s
