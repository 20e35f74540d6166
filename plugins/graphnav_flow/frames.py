"""Prepare the images of an estimator: gray, of equal size, with the intervals between them."""

from __future__ import annotations

import cv2

from graphnav import Continuity, Image, Stamp
from graphnav.arrays import Bytes


class Frames:
    """Converts a sequence of images to gray and measures the intervals.

    The first image fixes the size of all others.
    """

    def __init__(self) -> None:
        self._shape: tuple[int, ...] | None = None
        self._last: Stamp | None = None
        self._continuity = Continuity()

    def next(self, image: Image, stamp: Stamp) -> tuple[Bytes, int]:
        """Return ``image`` as uint8 (rows, cols) and the microseconds since the one before.

        The interval is 0 if there is no image to compare with: for the first image, and for the first after a gap of
        more than 3 typical periods, across which no estimator can match.

        Raises
        ------
        ValueError
            The size differs from that of the first image.
        """
        shape = image.pixels.shape[:2]
        if self._shape is None:
            self._shape = shape
        elif shape != self._shape:
            raise ValueError(
                f"the image is {shape[1]}x{shape[0]}, but the ones before were {self._shape[1]}x{self._shape[0]}"
            )
        is_broken = self._continuity.breaks(stamp)
        interval_us = 0 if self._last is None or is_broken else stamp - self._last
        self._last = stamp
        return to_gray(image), interval_us


def to_gray(image: Image) -> Bytes:
    """Return ``image`` in gray, uint8 (rows, cols); the pixels themselves if it is gray already."""
    if image.pixels.ndim == 2:
        return image.pixels
    gray: Bytes = cv2.cvtColor(image.pixels, cv2.COLOR_RGB2GRAY)
    return gray
