"""A source of images: picture files."""

from __future__ import annotations

from pathlib import Path

from graphnav import Image, Source, param
from graphnav_io.pictures import PictureFrames, check_pictures, find_pictures
from graphnav_io.playback import next_image
from graphnav_io.preparation import Prepared


class Images(Prepared, Source):
    """Pictures in files, one per firing, in natural order (frame_2 before frame_10); the last one ends the run.

    They are prepared: converted to gray, undistorted, rotated, cropped and resized, in this order. A picture that
    cannot be decoded, or has another size than the first, stops the run.
    """

    path: Path = param(doc="a folder of pictures, or a pattern like run/*.jpg")

    def check(self) -> None:
        """Check that there are pictures and that the first one can be decoded."""
        super().check()
        self.check_picture(check_pictures(self.path))

    def reset(self, seed: int) -> None:  # noqa: ARG002
        """Begin with the first picture."""
        self._frames = PictureFrames(find_pictures(self.path))
        self._preparation = self.preparation()

    def step(self) -> Image:
        """Return the next picture."""
        return next_image(self._frames, self._preparation)
