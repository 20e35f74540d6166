"""The panels of frames that are asked for by their time."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from graphnav_view.panels.frame_times import frame_stamps, frame_utime
from graphnav_view.panels.key_panels import draw_frame
from graphnav_view.panels.norms_page import draw_norms_at
from graphnav_view.panels.separation_page import draw_separation
from graphnav_view.signals import Signals


def draw_frames(signals: Signals, times_s: Sequence[float], folder: Path, suffix: str) -> list[Path] | None:
    """Draw the panels of the frames nearest to some times (seconds from the start of the log), one picture each.

    A frame with independent components has two more, of these and of their sorted lengths. None where the log holds
    nothing that a camera saw. Raises UserError for a time outside of it.
    """
    stamps = frame_stamps(signals)
    if not stamps:
        return None
    utimes = dict.fromkeys(frame_utime(signals, stamps, time_s) for time_s in times_s)
    drawn: list[Path | None] = []
    for utime in utimes:
        end = f"{signals.at_s(utime):.2f}s{suffix}"
        drawn.append(draw_frame(signals, utime, folder / f"panels_{end}"))
        drawn.append(draw_separation(signals, utime, folder / f"components_{end}"))
        drawn.append(draw_norms_at(signals, utime, folder / f"norms_{end}"))
    return [path for path in drawn if path is not None]
