"""A source of images: picture files."""

from __future__ import annotations

from pathlib import Path

from graphnav import Image, Source, param
from graphnav_io.pictures import PictureFrames, check_pictures, find_pictures
from graphnav_io.playback import next_image
from graphnav_io.shape import GRAY_DOC, SCALE_DOC, SIZE_DOC, Shape, check_shape


class Images(Source):
    """Pictures in files, one per firing, in natural order (frame_2 before frame_10); the last one ends the run.

    A picture that cannot be decoded, or has another size than the first, stops the run.
    """

    path: Path = param(doc="a folder of pictures, or a pattern like run/*.jpg")
    size: tuple[int, int] | None = param(None, ge=1, le=16384, doc=SIZE_DOC)
    scale: float = param(1.0, gt=0.0, le=16.0, doc=SCALE_DOC)
    gray: bool = param(False, doc=GRAY_DOC)

    def check(self) -> None:
        """Check that there are pictures and that the first one can be decoded."""
        check_shape(self.size, self.scale)
        check_pictures(self.path)

    def reset(self, seed: int) -> None:  # noqa: ARG002
        """Begin with the first picture."""
        self._frames = PictureFrames(find_pictures(self.path))
        self._shape = Shape(self.size, self.scale, gray=self.gray)

    def step(self) -> Image:
        """Return the next picture."""
        return next_image(self._frames, self._shape)
