"""Prepare the pictures of a live camera."""

from __future__ import annotations

from graphnav import Image
from graphnav_io.preparation import Prepared


class Prepare(Prepared):
    """Convert to gray, undistort, rotate, crop and resize, in this order: for an input, as `Images` and `Video` do.

    The pictures of a graph with inputs come from a channel; this stage stands behind it. The maps are computed for the
    first picture, which fixes the size: a picture of another size ends the run.
    """

    def reset(self, seed: int) -> None:  # noqa: ARG002  # nothing is random
        """Forget the size of the first picture."""
        self._preparation = self.preparation()

    def step(self, image: Image) -> Image:
        """Return the prepared picture.

        Raises
        ------
        ValueError
            The picture does not have the size of the calibration or of the first one, or the crop leaves it.
        """
        return Image(pixels=self._preparation.apply(image.pixels))
