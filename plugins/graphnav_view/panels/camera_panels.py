"""The panels on the camera's pixels: image, optical flow, dominant plane."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.patches import Circle, PathPatch
from matplotlib.path import Path

from graphnav import Image, Plane
from graphnav.arrays import Bools
from graphnav_view import style
from graphnav_view.flow_colour import flow_rgb, flow_scale_px, wheel_rgb
from graphnav_view.panels.keyframe import Frame

_ARROWS_ACROSS = 16
_WHEEL_IN = 0.42
_GROUND, _OBSTACLE, _UNJUDGED = 255, 25, 205


def draw_image(axes: Axes, frame: Frame) -> str:
    """Show the camera's picture; return its caption."""
    assert frame.image is not None
    show_image(axes, frame, frame.image)
    rows, cols = frame.shape_px
    return f"what the camera sees, {cols} x {rows} px"


def show_image(axes: Axes, frame: Frame, image: Image) -> None:
    """Put the camera's picture into axes that count its pixels."""
    gray = image.pixels.ndim == 2
    over_picture(axes, frame)
    axes.imshow(
        image.pixels,
        extent=extent_px(image.pixels.shape, image.step_px),
        cmap="gray" if gray else None,
        vmin=0,
        vmax=255,
        interpolation="antialiased",
        aspect="auto",
    )
    over_picture(axes, frame)


def draw_flow(axes: Axes, frame: Frame) -> str:
    """Draw the flow in colour with arrows on it; return its caption."""
    flow = frame.flow
    assert flow is not None
    full = show_vectors(axes, frame, Field(flow.uv_px, flow.valid, flow.step_px))
    per_s = full / (flow.interval_us / 1e6) if flow.interval_us else 0.0
    speed = f" = {per_s:.0f} px/s" if per_s else ""
    return f"displacement since the last frame; colour: direction,\nsaturation: length, full at {full:.1f} px{speed}"


class Field(NamedTuple):
    """Vectors (rows, cols, 2), right and down, which of them count, (rows, cols), and the pixels of a cell."""

    uv: npt.NDArray[Any]
    valid: npt.NDArray[Any]
    step_px: int


def show_vectors(
    axes: Axes, frame: Frame, field: Field, full: float | None = None, *, with_wheel: bool = True
) -> float:
    """Draw a field in colour with arrows on it and the colours of the directions; return the length in full colour.

    Given this length, ``full``, longer vectors are drawn as long as it.
    """
    if full is None:
        full = flow_scale_px(field.uv, field.valid)
    else:
        length = np.linalg.norm(field.uv, axis=-1, keepdims=True)
        field = field._replace(uv=field.uv * (full / np.maximum(length, full)))
    axes.imshow(
        flow_rgb(field.uv, field.valid, full),
        extent=extent_px(field.valid.shape, field.step_px),
        interpolation="nearest",
        aspect="auto",
    )
    over_picture(axes, frame)
    every = max(1, round(field.valid.shape[1] / _ARROWS_ACROSS))
    x, y, picked = _lattice(field.valid.shape, field.step_px, every)
    uv, there = field.uv[picked], field.valid[picked] != 0
    axes.quiver(
        x[there],
        y[there],
        uv[there][:, 0],
        uv[there][:, 1],
        angles="xy",
        scale_units="xy",
        scale=full / (every * field.step_px * 1.1),
        width=0.006,
        color="black",
        headwidth=3.6,
        headlength=4.2,
    )
    if with_wheel:
        _wheel(axes)
    return full


def draw_plane(axes: Axes, frame: Frame) -> str:
    """Draw the dominant map, ground white and obstacle black as the paper does; return its caption."""
    plane = frame.plane
    assert plane is not None
    shown = np.where(plane.obstacle != 0, _OBSTACLE, _GROUND).astype(np.uint8)
    shown[plane.valid == 0] = _UNJUDGED
    extent = extent_px(shown.shape, plane.step_px)
    axes.imshow(shown, extent=extent, cmap="gray", vmin=0, vmax=255, interpolation="nearest", aspect="auto")
    hatch_unjudged(axes, plane)
    over_picture(axes, frame)
    unknown = plane.unknown()
    words = ["black: obstacle"]
    words += ["gray: rim"] if ((plane.valid == 0) & ~unknown).any() else []
    words += ["violet: unknown"] if unknown.any() else []
    return f"{', '.join(words)};\nobstacle is {plane.obstacle_ratio:.0%} of what was judged"


def hatch_unjudged(axes: Axes, plane: Plane) -> None:
    """Hatch the cells that were not judged: the rim gray, unknown cells violet and crosswise."""
    rim = (plane.valid == 0) & ~plane.unknown()
    _hatch(axes, rim, plane.step_px, "/////", edgecolor="#8a8a8a", facecolor="none")
    hatch_unknown(axes, plane)


def hatch_unknown(axes: Axes, plane: Plane) -> None:
    """Hatch the unknown cells crosswise, in violet."""
    _hatch(axes, plane.unknown(), plane.step_px, "xxxxx", edgecolor=style.UNKNOWN, facecolor="#e4dcf7")


def _hatch(axes: Axes, there: Bools, step_px: int, hatch: str, *, edgecolor: str, facecolor: str) -> None:
    """Hatch cells (rows, cols), as one shape of runs along the rows."""
    runs = []
    for row, cells in enumerate(there):
        edges = np.flatnonzero(np.diff(cells.astype(np.int8), prepend=0, append=0)) * step_px - 0.5
        top, low = row * step_px - 0.5, (row + 1) * step_px - 0.5
        runs += [[(x0, top), (x1, top), (x1, low), (x0, low)] for x0, x1 in edges.reshape(-1, 2)]
    if runs:
        outline = Path.make_compound_path_from_polys(np.array(runs))
        axes.add_patch(PathPatch(outline, facecolor=facecolor, edgecolor=edgecolor, lw=0.0, hatch=hatch))


def extent_px(shape: tuple[int, ...], step_px: int) -> tuple[float, float, float, float]:
    """Return left, right, bottom, top of a grid in the picture's pixels, whose centres are integers."""
    rows, cols = shape[:2]
    return -0.5, cols * step_px - 0.5, rows * step_px - 0.5, -0.5


def over_picture(axes: Axes, frame: Frame) -> None:
    """Let the axes show the picture's pixels, rows down, without ticks."""
    rows, cols = frame.shape_px
    axes.set_xlim(-0.5, cols - 0.5)
    axes.set_ylim(rows - 0.5, -0.5)
    axes.set_xticks([])
    axes.set_yticks([])


def _lattice(shape: tuple[int, ...], step_px: int, every: int) -> tuple[npt.NDArray[Any], npt.NDArray[Any], Any]:
    """Return x, y (pixels) of every so-manieth cell, and what picks these cells from a grid."""
    rows = slice(every // 2, shape[0], every)
    cols = slice(every // 2, shape[1], every)
    at = (np.mgrid[rows, cols] + 0.5) * step_px - 0.5
    return at[1], at[0], (rows, cols)


def _wheel(axes: Axes) -> None:
    """Show in the lower right corner which colour is which direction."""
    rgb, disc = wheel_rgb(120)
    rgba = np.dstack([rgb, np.where(disc, 255, 0).astype(np.uint8)])
    box = axes.get_window_extent()
    width, height = _WHEEL_IN * style.DPI / box.width, _WHEEL_IN * style.DPI / box.height
    inset = axes.inset_axes((1 - 1.15 * width, 0.15 * height, width, height), zorder=5)
    inset.imshow(rgba, interpolation="antialiased")
    inset.add_patch(Circle((59.5, 59.5), 59, fill=False, lw=1.0))
    inset.set_axis_off()
