"""Draw the pictures of a run from its log with the drawing plugins."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from graphnav.core.catalog import Catalog
from graphnav.core.errors import GraphnavError
from graphnav.core.pictures import DRAWING_FAMILY, drawing
from graphnav.core.record import Recording
from graphnav.core.run_folder import RunFolder

PNG = ".png"


def draw_all(
    catalog: Catalog, recording: Recording, folder: Path, suffix: str = PNG, *, video: bool = False
) -> list[Path]:
    """Draw all pictures that the installed drawing plugins make of a log into ``folder``; return the files.

    ``suffix``: the format, ``.png``, ``.svg`` or ``.pdf``. ``video``: also draw the panels as a video.

    Raises
    ------
    DrawingError
        A plugin cannot draw the content of the log; pictures drawn before are kept.
    GraphnavError
        A picture cannot be written; it can be drawn later from the log.
    """
    with _drawing_into(catalog, recording, folder):
        drawn = catalog.hook.graphnav_draw(recording=recording, folder=folder, video=video, suffix=suffix)
    return [path for paths in drawn for path in paths]


def draw_frames(
    catalog: Catalog, recording: Recording, times_s: Sequence[float], folder: Path, suffix: str
) -> list[Path]:
    """Draw the panels of the frames nearest to ``times_s`` (seconds from the start); raises as `draw_all`.

    Raises UserError for a time outside the log.
    """
    with _drawing_into(catalog, recording, folder):
        drawn = catalog.hook.graphnav_draw_frames(recording=recording, times_s=times_s, folder=folder, suffix=suffix)
    return drawn or []


def draw_rows(
    catalog: Catalog, recording: Recording, times_s: Sequence[float], folder: Path, suffix: str
) -> list[Path]:
    """Draw the frames nearest to ``times_s`` (seconds from the start) into one picture; raises as `draw_frames`."""
    with _drawing_into(catalog, recording, folder):
        drawn = catalog.hook.graphnav_draw_rows(recording=recording, times_s=times_s, file=folder / f"rows{suffix}")
    return [] if drawn is None else [drawn]


def draw_sheet(
    catalog: Catalog, recording: Recording, every_s: float, span_s: tuple[float, float], folder: Path, suffix: str
) -> list[Path]:
    """Draw a contact sheet, a frame every ``every_s`` of ``span_s`` (from the start); raises as `draw_all`.

    Raises UserError for a span without frames, or with too many.
    """
    from_s, until_s = span_s
    with _drawing_into(catalog, recording, folder):
        drawn = catalog.hook.graphnav_draw_sheet(
            recording=recording, every_s=every_s, from_s=from_s, until_s=until_s, file=folder / f"sheet{suffix}"
        )
    return [] if drawn is None else [drawn]


@contextmanager
def _drawing_into(catalog: Catalog, recording: Recording, folder: Path) -> Iterator[None]:
    catalog.load(DRAWING_FAMILY)
    try:
        with drawing():
            yield
    except OSError as error:
        log = recording.path
        run = log.parent if log.name == RunFolder.LOG else log
        elsewhere = f" -o {folder}" if folder != log.parent else ""
        raise GraphnavError(
            f"cannot draw into {folder}: {error.strerror}\n  free space, then run: graphnav figure {run}{elsewhere}"
        ) from error
