"""The panels of the obstacle potential: the Gaussian, its gradients and their cloud."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes

from graphnav.arrays import Doubles
from graphnav_view import style
from graphnav_view.panels.camera_panels import extent_px, hatch_unknown, over_picture
from graphnav_view.panels.keyframe import Frame

_ARROWS_ACROSS = 16
_FIELD = "#27476e"
_MAX_POINTS = 1500
_MEAN = "#2a9d8f"


def draw_potential(axes: Axes, frame: Frame) -> str:
    """Draw the Gaussian of the dominant map with lines of equal potential; return its caption."""
    potential = frame.potential
    assert potential is not None
    values = potential.potential
    low, high = float(values.min()), float(values.max())
    extent = extent_px(values.shape, potential.step_px)
    axes.imshow(
        values,
        extent=extent,
        cmap="gray",
        vmin=low,
        vmax=max(high, low + 1e-6),
        interpolation="bilinear",
        aspect="auto",
    )
    if high - low > 1e-6 and min(values.shape) > 1:
        rows, cols = values.shape
        x = (np.arange(cols) + 0.5) * potential.step_px - 0.5
        y = (np.arange(rows) + 0.5) * potential.step_px - 0.5
        axes.contour(x, y, values, levels=np.linspace(low, high, 9)[1:-1], colors="#f4a259", linewidths=0.9)
    over_picture(axes, frame)
    caption = "Gaussian of the obstacle (255) and ground (0):\n"
    return caption + f"black {low:.1f}, white {high:.1f}; lines of equal potential"


def draw_gradient(axes: Axes, frame: Frame) -> str:
    """Draw the gradients, turned so that they point away from the obstacle; return the caption."""
    potential = frame.potential
    assert potential is not None
    if frame.plane is not None:
        shown = np.where(frame.plane.obstacle != 0, 205, 255).astype(np.uint8)
        extent = extent_px(shown.shape, frame.plane.step_px)
        axes.imshow(shown, extent=extent, cmap="gray", vmin=0, vmax=255, interpolation="nearest", aspect="auto")
        hatch_unknown(axes, frame.plane)
    over_picture(axes, frame)
    rows, cols = potential.potential.shape
    every = max(1, round(cols / _ARROWS_ACROSS))
    picked = (slice(every // 2, rows, every), slice(every // 2, cols, every))
    at = (np.mgrid[picked] + 0.5) * potential.step_px - 0.5
    away = -potential.gradient[picked]
    longest = float(np.hypot(away[..., 0], away[..., 1]).max(initial=0.0))  # a field may be too small for any arrow
    if longest > 0:
        axes.quiver(
            at[1],
            at[0],
            away[..., 0],
            away[..., 1],
            angles="xy",
            scale_units="xy",
            pivot="mid",
            scale=longest / (every * potential.step_px * 1.25),
            width=0.007,
            color=_FIELD,
            headwidth=3.6,
            headlength=4.2,
        )
    return f"away from the obstacle (gray);\nlongest arrow {longest:.2f} per cell"


@dataclass(frozen=True)
class Principal:
    """First principal direction of a cloud of gradients (n, 2): unit vector, eigenvalues largest first."""

    direction: Doubles
    eigenvalues: Doubles


def principal(cloud: Doubles, published: Doubles | None) -> Principal:
    """Return the direction v1 of the gradients that point away from the obstacle, signed as their mean.

    About their centroid [OI, eq. 7] or about zero: whichever gives the eigenvalues ``published`` by the steering.
    """
    mean = cloud.mean(axis=0)
    second = cloud.T @ cloud / len(cloud)
    found = []
    for moment in (second - np.outer(mean, mean), second):
        values, vectors = np.linalg.eigh(moment)
        v1 = vectors[:, 1]
        found.append(Principal(v1 if v1 @ mean >= 0 else -v1, values[::-1]))
    if published is None or not len(published):
        return found[0]
    return min(found, key=lambda p: float(np.abs(p.eigenvalues - published).sum()))


def draw_cloud(axes: Axes, frame: Frame) -> str:
    """Draw all gradients as points, their mean and v1; return the caption."""
    potential, steering = frame.potential, frame.steering
    assert potential is not None
    cloud = (-potential.gradient.reshape(-1, 2) * np.array([1.0, -1.0])).astype(np.float64)
    longest = float(np.hypot(cloud[:, 0], cloud[:, 1]).max())
    axes.axhline(0, color="#c8c8c8", lw=0.8, zorder=0)
    axes.axvline(0, color="#c8c8c8", lw=0.8, zorder=0)
    shown = cloud[:: max(1, len(cloud) // _MAX_POINTS)]
    axes.scatter(shown[:, 0], shown[:, 1], s=7, color=_FIELD, alpha=0.45, linewidths=0, zorder=2)
    _limits(axes, longest)
    axes.set_xticks([])
    axes.set_yticks([])
    axes.text(
        0.985,
        0.515,
        "right",
        transform=axes.transAxes,
        ha="right",
        va="bottom",
        fontsize=8.6,
        color=style.QUIET,
        path_effects=style.halo(),
    )
    axes.text(
        0.515,
        0.98,
        "forward",
        transform=axes.transAxes,
        ha="left",
        va="top",
        fontsize=8.6,
        color=style.QUIET,
        path_effects=style.halo(),
    )
    if longest == 0:
        return "no obstacle: every gradient is zero"
    found = principal(cloud, None if steering is None else steering.eigenvalues)
    mean = cloud.mean(axis=0)
    tip = found.direction * longest * 0.98
    axes.annotate(
        "",
        (tip[0], tip[1]),
        (0, 0),
        zorder=4,
        arrowprops={"arrowstyle": "-|>", "color": style.REPULSIVE, "lw": 2.2, "shrinkA": 0, "shrinkB": 0},
    )
    side = np.array([-found.direction[1], found.direction[0]]) * longest * 0.14
    x, y = tip * 0.86 + (side if side[1] >= 0 else -side)
    axes.text(
        x,
        y,
        "v$_1$",
        color=style.REPULSIVE,
        fontsize=12,
        fontweight="bold",
        ha="center",
        va="center",
        zorder=6,
        path_effects=style.halo(),
    )
    axes.plot(*mean, marker="D", ms=7, color=_MEAN, mec="white", mew=1.0, zorder=5)
    first, second = found.eigenvalues
    ratio = "∞" if second <= 1e-9 * first else f"{first / second:.1f}"
    caption = "one point per cell, potential per cell; diamond: mean;\n"
    return caption + f"v$_1$: first principal direction, λ$_1$/λ$_2$ = {ratio}"


def _limits(axes: Axes, max_abs: float) -> None:
    """Show everything up to ``max_abs`` with equal scales in the shape of the axes."""
    box = axes.get_window_extent()
    shape = box.width / box.height
    half = 1.12 * (max_abs or 1.0)
    axes.set_xlim(-half * max(shape, 1.0), half * max(shape, 1.0))
    axes.set_ylim(-half / min(shape, 1.0), half / min(shape, 1.0))
