"""The sensor of a camera: which rows are read when, and what of the pinhole's picture a lens shows in them."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple, Protocol

import numpy as np

from graphnav.arrays import Bytes, Floats, Ints
from graphnav_world.rendering.camera import Camera
from graphnav_world.rendering.lens import Lens, Samples

STEP_PX = 0.25
"""How far the picture moves between two strips of rows, at most about."""


class AnyFrame(Protocol):
    """Gray values of some rows of a picture and their ground truth, whatever renders them."""

    @property
    def gray(self) -> Floats:
        """Sum of the gray values of all views, before brightness and noise, float32 (rows, cols)."""
        ...

    @property
    def views(self) -> int:
        """The number of views while the shutter was open."""
        ...

    @property
    def surface(self) -> Ints:
        """Which surface is seen, (rows, cols): a face or a body, below 0 none."""
        ...

    @property
    def obstacle(self) -> Bytes:
        """Where a body is seen: uint8 (rows, cols), 1 there."""
        ...

    @property
    def depth_m(self) -> Floats:
        """Depth along the optical axis, float32 (rows, cols), infinite above the horizon."""
        ...

    @property
    def flow_px(self) -> Floats | None:
        """Displacement of every pixel's surface point, right and down, float32 (rows, cols, 2); None at first."""
        ...


class Strip(NamedTuple):
    """Rows that are read at one time, seconds after the frame's, and the pinhole's rows of which they are made."""

    rows: range
    window: range
    after_s: float


Taken = Callable[[Strip], AnyFrame]
"""Renders the window of a strip at its time."""


class Sensor:
    """Reads a picture row by row, through a lens if there is one.

    ``readout_s``: from the first row to the last one; the middle of the picture is read at the frame's time.
    """

    def __init__(self, camera: Camera, lens: Lens | None, readout_s: float) -> None:
        self._rows, self._lens, self._readout_s = camera.rows, lens, readout_s

    def strips(self, moving_px: float) -> list[Strip]:
        """Return the strips of a picture that moves so far during the readout: one, if it does not."""
        count = min(max(math.ceil(moving_px / STEP_PX), 1), self._rows)
        bounds = [round(k * self._rows / count) for k in range(count + 1)]
        return [self._strip(range(first, stop)) for first, stop in pairwise(bounds)]

    def _strip(self, rows: range) -> Strip:
        window = rows if self._lens is None else self._lens.window(rows)
        from_middle = (rows.start + rows.stop - self._rows) / 2
        return Strip(rows, window, self._readout_s * from_middle / (self._rows - 1))

    def read(self, strips: Sequence[Strip], taken: Taken) -> AnyFrame:
        """Return the frame of these strips."""
        if len(strips) == 1 and self._lens is None:
            return taken(strips[0])
        parts: list[AnyFrame] = [taken(strip) for strip in strips]
        if self._lens is not None:
            parts = [Shown(part, self._lens, strip) for part, strip in zip(parts, strips, strict=True)]
        return parts[0] if len(parts) == 1 else Joined(parts)


@dataclass(frozen=True)
class Joined:
    """A frame of strips, one below the other."""

    parts: Sequence[AnyFrame]

    @property
    def views(self) -> int:
        """As of `AnyFrame`."""
        return self.parts[0].views

    @property
    def gray(self) -> Floats:
        """As of `AnyFrame`."""
        return np.concatenate([part.gray for part in self.parts])

    @property
    def surface(self) -> Ints:
        """As of `AnyFrame`."""
        return np.concatenate([part.surface for part in self.parts])

    @property
    def obstacle(self) -> Bytes:
        """As of `AnyFrame`."""
        return np.concatenate([part.obstacle for part in self.parts])

    @property
    def depth_m(self) -> Floats:
        """As of `AnyFrame`."""
        return np.concatenate([part.depth_m for part in self.parts])

    @property
    def flow_px(self) -> Floats | None:
        """As of `AnyFrame`."""
        flows = [flow for part in self.parts if (flow := part.flow_px) is not None]
        return np.concatenate(flows) if flows else None


@dataclass(frozen=True)
class Shown:
    """The view of a strip, of the pinhole's frame ``taken`` through a lens.

    The mask is that of the nearest pixel of the pinhole's picture. Depth and flow are interpolated where the pixels
    around show one surface, else theirs; inverse depth is linear in the picture of a plane, so that its depth is exact.
    """

    taken: AnyFrame
    lens: Lens
    strip: Strip

    @property
    def views(self) -> int:
        """As of `AnyFrame`."""
        return self.taken.views

    @property
    def gray(self) -> Floats:
        """As of `AnyFrame`."""
        return self.lens.shown(self.taken.gray, self.strip.rows, self.strip.window)

    @property
    def surface(self) -> Ints:
        """As of `AnyFrame`."""
        return self._samples.nearest(self.taken.surface)

    @property
    def obstacle(self) -> Bytes:
        """As of `AnyFrame`."""
        return self._samples.nearest(self.taken.obstacle)

    @property
    def depth_m(self) -> Floats:
        """As of `AnyFrame`."""
        (inverse_depth,) = self._samples.between([np.reciprocal(self.taken.depth_m)], self.taken.surface)
        with np.errstate(divide="ignore"):
            return np.reciprocal(inverse_depth)

    @property
    def flow_px(self) -> Floats | None:
        """As of `AnyFrame`."""
        flow = self.taken.flow_px
        if flow is None:
            return None
        moved = np.stack(self._samples.between([flow[..., 0], flow[..., 1]], self.taken.surface), axis=-1)
        before = self._samples.place - moved
        rows, cols = np.indices(moved.shape[:2])
        now = np.stack([cols, rows + self.strip.rows.start], axis=-1)
        displaced: Floats = (now - self.lens.distorted_px(before)).astype(np.float32)
        return displaced

    @property
    def _samples(self) -> Samples:
        return self.lens.samples(self.strip.rows, self.strip.window)
