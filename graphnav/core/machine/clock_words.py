"""Offsets of clocks in words, and what to do about one that matters."""

from __future__ import annotations

NOTABLE_OFFSET_S = 0.2
"""A smaller offset may be a delay of transport."""
SET_ALIKE = "set the clocks of all machines alike, by chrony or PTP"
_DAY_S = 86_400.0


def span_text(seconds: float) -> str:
    """Return the size of an offset in a readable unit."""
    size_s = abs(seconds)
    if size_s < 0.1:
        return f"{size_s * 1e3:.1f} ms"
    if size_s < _DAY_S:
        return f"{size_s:.2f} s" if size_s < 100 else f"{size_s:.0f} s"
    return f"{size_s / _DAY_S:.0f} days"


def side_text(offset_s: float) -> str:
    """Return on which side of another clock a clock is."""
    return "behind" if offset_s < 0 else "ahead of"


def offset_text(offset_s: float, error_s: float, drift_ppm: float | None = None) -> str:
    """Return how far a clock is from this machine's, and its drift if that is known."""
    if abs(offset_s) <= error_s:
        text = f"alike within {span_text(error_s)}"
    else:
        text = f"{span_text(offset_s)} {'behind' if offset_s < 0 else 'ahead'} ± {span_text(error_s)}"
    return text if drift_ppm is None else f"{text}, {round(drift_ppm)} ppm"


def set_text(step_s: float) -> str:
    """Return how a clock was set that was set by so much."""
    return f"was set {span_text(step_s)} {'back' if step_s < 0 else 'ahead'}"
