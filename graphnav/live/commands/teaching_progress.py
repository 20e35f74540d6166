"""Show what a live run has taught."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.text import Text

from graphnav.core.machine import Console
from graphnav.live.teaching import Taught, gaps

LINE_S = 10.0
"""Time between two lines without a terminal."""


@contextmanager
def teaching_progress(console: Console, taught: Taught) -> Iterator[Callable[[float], None]]:
    """Yield a function that shows the progress at a time of the run in seconds."""
    if console.is_terminal:
        with console.status("") as status:
            yield lambda run_s: status.update(Text(progress_line(taught, run_s)))
        return
    shown_s = 0.0

    def show(run_s: float) -> None:
        nonlocal shown_s
        if run_s >= shown_s + LINE_S:
            shown_s = run_s
            console.print(progress_line(taught, run_s), markup=False)

    yield show


def progress_line(taught: Taught, run_s: float) -> str:
    """Return frames, spans of speed and turning rate, and the residual of the newest model, or what is missing."""
    parts = [f"{run_s:.0f} s", f"{taught.flows} frames"]
    if len(rates := taught.rates):
        (v_low, w_low), (v_high, w_high) = rates.min(axis=0), rates.max(axis=0)
        parts += [f"v {v_low:.2f} to {v_high:.2f} m/s", f"omega {w_low:.2f} to {w_high:.2f} rad/s"]
    residual = f"residual {taught.residuals_px[-1]:.3f} px" if taught.residuals_px else "no model yet"
    return ", ".join([*parts, residual, *gaps(taught)])
