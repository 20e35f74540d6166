"""Draw the pictures of a run from its log with the drawing plugins."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from graphnav.core.catalog import Catalog
from graphnav.core.errors import GraphnavError
from graphnav.core.pictures import DRAWING_FAMILY, drawing
from graphnav.core.record import Recording
from graphnav.core.run_folder import RunFolder

PNG = ".png"


@dataclass(frozen=True)
class LogPictures:
    """Draws pictures of a log into a folder, which its methods return the files of.

    ``suffix``: the format, ``.png``, ``.svg`` or ``.pdf``. Every method raises DrawingError if a plugin cannot draw the
    content of the log, pictures drawn before are kept; and GraphnavError if a picture cannot be written, which can be
    drawn later from the log.
    """

    catalog: Catalog
    recording: Recording
    folder: Path
    suffix: str = PNG

    def draw(self, *, video: bool = False) -> list[Path]:
        """Draw all pictures that the installed drawing plugins make; with ``video`` also the panels as a video."""
        with self._drawing():
            drawn = self.catalog.hook.graphnav_draw(
                recording=self.recording, folder=self.folder, video=video, suffix=self.suffix
            )
        return [path for paths in drawn for path in paths]

    def draw_frames(self, times_s: Sequence[float]) -> list[Path]:
        """Draw the panels of the frames nearest to ``times_s``, seconds from the start.

        Raises UserError for a time outside the log.
        """
        with self._drawing():
            drawn = self.catalog.hook.graphnav_draw_frames(
                recording=self.recording, times_s=times_s, folder=self.folder, suffix=self.suffix
            )
        return drawn or []

    def draw_rows(self, times_s: Sequence[float]) -> list[Path]:
        """Draw the frames nearest to ``times_s`` into one picture; raises as `draw_frames`."""
        with self._drawing():
            drawn = self.catalog.hook.graphnav_draw_rows(
                recording=self.recording, times_s=times_s, file=self.folder / f"rows{self.suffix}"
            )
        return [] if drawn is None else [drawn]

    def draw_separation(self, times_s: Sequence[float]) -> list[Path]:
        """Draw how the frames nearest to ``times_s`` were separated into one picture; raises as `draw_frames`.

        Raises UserError also for a log without independent components.
        """
        with self._drawing():
            drawn = self.catalog.hook.graphnav_draw_separation(
                recording=self.recording, times_s=times_s, file=self.folder / f"separation{self.suffix}"
            )
        return [] if drawn is None else [drawn]

    def draw_sheet(self, every_s: float, from_s: float, until_s: float) -> list[Path]:
        """Draw a contact sheet, a frame every ``every_s`` of a span, seconds from the start.

        Raises UserError for a span without frames, or with too many.
        """
        file = self.folder / f"sheet{self.suffix}"
        with self._drawing():
            drawn = self.catalog.hook.graphnav_draw_sheet(
                recording=self.recording, every_s=every_s, from_s=from_s, until_s=until_s, file=file
            )
        return [] if drawn is None else [drawn]

    @contextmanager
    def _drawing(self) -> Iterator[None]:
        self.catalog.load(DRAWING_FAMILY)
        try:
            with drawing():
                yield
        except OSError as error:
            log = self.recording.path
            run = log.parent if log.name == RunFolder.LOG else log
            elsewhere = f" -o {self.folder}" if self.folder != log.parent else ""
            what = f"cannot draw into {self.folder}: {error.strerror}"
            raise GraphnavError(f"{what}\n  free space, then run: graphnav figure {run}{elsewhere}") from error
