"""The panel of the direction of attention: the forces on the camera's picture."""

from __future__ import annotations

import math

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Arc, FancyArrowPatch

from graphnav.arrays import Doubles
from graphnav_view import style
from graphnav_view.panels.camera_panels import over_picture, show_image
from graphnav_view.panels.keyframe import Frame, from_forward

_HEIGHT_RATIO, _HALF_WIDTH_RATIO = 0.68, 0.36
"""Extent of the arrows as shares of the picture: of its height, and of its width to each side."""
_NAME_IN = 0.16
"""Distance of a force's name from its tip."""


def draw_direction(axes: Axes, frame: Frame) -> str:
    """Draw r, w, p = r + w and theta on a frame that was steered; return the caption."""
    steering = frame.steering
    assert steering is not None
    if frame.image is not None:
        show_image(axes, frame, frame.image)
    else:
        over_picture(axes, frame)
        axes.set_facecolor("#9a9a9a")
    rows, cols = frame.shape_px
    forces = {"r": steering.repulsive, "w": steering.guiding, "p": steering.control}
    origin, scale = _fitted(np.array(list(forces.values())), rows, cols)
    axes.plot([origin[0]] * 2, [rows - 0.5, -0.5], color="white", lw=1.0, ls=(0, (4, 4)), alpha=0.8)
    tips = {name: origin + scale * force * np.array([1.0, -1.0]) for name, force in forces.items()}
    for start, end in (("r", "p"), ("w", "p")):
        axes.plot(*np.stack([tips[start], tips[end]]).T, color="white", lw=1.0, ls=":", alpha=0.9)
    for name, colour in (("r", style.REPULSIVE), ("w", style.GUIDING), ("p", style.CONTROL)):
        if np.hypot(*forces[name]) * scale > 2.0:
            _arrow(axes, origin, tips[name], colour, thick=name == "p")
    _name_tips(axes, origin, tips)
    _arc(axes, origin, steering.theta_rad, 0.6 * scale * min(float(np.hypot(*forces[name])) for name in "pw"))
    axes.plot(*origin, marker="o", ms=5, color="white", mec="black", mew=1.0, zorder=7)
    caption = f"θ = {from_forward(steering.theta_rad)}; red: r, repulsive;\n"
    return caption + "blue: w, guiding; yellow: p = r + w, control"


def _fitted(forces: Doubles, rows: int, cols: int) -> tuple[Doubles, float]:
    """Return the origin of the arrows of the forces (n, 2) and the pixels per unit, so that all are visible.

    The origin is in the picture's middle column, as low as arrows that point back allow.
    """
    forward, back = max(0.0, float(forces[:, 1].max())), max(0.0, -float(forces[:, 1].min()))
    aside = float(np.abs(forces[:, 0]).max())
    scale = min(_HEIGHT_RATIO * rows / max(forward + back, 1e-9), _HALF_WIDTH_RATIO * cols / max(aside, 1e-9))
    return np.array([cols, rows + scale * (forward - back)]) / 2 - 0.5, scale


def _arrow(axes: Axes, start: Doubles, end: Doubles, colour: str, *, thick: bool) -> None:
    length_pt = 72 * float(np.hypot(*(end - start))) / _px_per_in(axes)
    axes.add_patch(
        FancyArrowPatch(
            (start[0], start[1]),
            (end[0], end[1]),
            arrowstyle="-|>",
            mutation_scale=min(20.0 if thick else 15.0, 0.7 * length_pt),
            shrinkA=0,
            shrinkB=0,
            color=colour,
            lw=3.4 if thick else 2.2,
            zorder=5 if thick else 6,
            joinstyle="miter",
            path_effects=style.halo(5.6 if thick else 4.0, "black"),
        )
    )


def _name_tips(axes: Axes, origin: Doubles, tips: dict[str, Doubles]) -> None:
    """Write the forces' names by their tips: beyond them, or beside them where there is more room."""
    px_per_in = _px_per_in(axes)
    taken: list[Doubles] = []
    for name, colour in (("p", style.CONTROL), ("r", style.REPULSIVE), ("w", style.GUIDING)):
        along = tips[name] - origin
        length = float(np.hypot(*along))
        if length <= 2.0:
            continue
        along /= length
        aside = np.array([-along[1], along[0]])
        places = [tips[name] + _NAME_IN * px_per_in * way for way in (along, aside - along, -aside - along)]
        shafts = [other for key, tip in tips.items() if key != name for other in np.linspace(origin, tip, 12)]
        rooms = [_room(place, [*taken, *shafts]) for place in places]
        roomy = [place for place, room in zip(places, rooms, strict=True) if room > 0.8 * _NAME_IN * px_per_in]
        at = roomy[0] if roomy else places[int(np.argmax(rooms))]
        taken.append(at)
        axes.text(
            at[0],
            at[1],
            name,
            color=colour,
            fontsize=13,
            fontweight="bold",
            ha="center",
            va="center",
            zorder=9,
            path_effects=style.halo(3.0, "black"),
        )


def _room(place: Doubles, others: list[Doubles]) -> float:
    """Return the distance of a point to the nearest of the others."""
    return min((float(np.hypot(*(place - other))) for other in others), default=math.inf)


def _px_per_in(axes: Axes) -> float:
    """Return the number of picture pixels per inch of paper."""
    return abs(float(np.ptp(axes.get_ylim()))) / (axes.get_window_extent().height / style.DPI)


def _arc(axes: Axes, origin: Doubles, theta_rad: float, radius_px: float) -> None:
    """Mark the angle from forward (up) to the control force."""
    degrees = math.degrees(theta_rad)
    if abs(degrees) < 3:
        return
    low, high = sorted((-90.0, -90.0 - degrees))
    axes.add_patch(
        Arc(
            (origin[0], origin[1]),
            2 * radius_px,
            2 * radius_px,
            theta1=low,
            theta2=high,
            color="white",
            lw=1.8,
            zorder=6,
        )
    )
