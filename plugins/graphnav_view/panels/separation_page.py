"""``components.png``: the mixtures of one frame, the independent components, and the dominant plane made of one."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes

from graphnav import Components, Plane
from graphnav.arrays import Doubles
from graphnav_view import style
from graphnav_view.panels import camera_panels
from graphnav_view.panels.camera_panels import Field, extent_px, hatch_unjudged, over_picture, show_vectors
from graphnav_view.panels.keyframe import Frame, frame_at, keyframe_utime
from graphnav_view.panels.panel_page import Panel, draw_page
from graphnav_view.panels.separated import NAMES
from graphnav_view.signals import Signals

COLOURS = ("#7a5195", "#e07a1f")
_POINTS = "#27476e"
_MAX_POINTS = 1500
_CROWD_PERCENT = 98.0
"""Share of the samples that the cloud of mixtures shows."""


def draw_components(signals: Signals, path: Path) -> Path | None:
    """Draw the separation of the keyframe into ``path``; None if the log has no components of it."""
    utime = keyframe_utime(signals)
    return None if utime is None else draw_separation(signals, utime, path)


def draw_separation(signals: Signals, utime: int, path: Path) -> Path | None:
    """Draw the separation of the frame that is stamped ``utime`` into ``path``; None if the log has none of it."""
    components = signals.at(Components, utime)
    if components is None:
        return None
    frame = frame_at(signals, utime)
    rows_px, cols_px = frame.shape_px
    small, large = components.variances.tolist()
    headline = (
        f"Frame at {frame.time_s:.2f} s · score from {NAMES[components.taken]} · variances {small:.3g} and {large:.3g}"
    )
    about = str(signals.graph.get("about") or "").strip()
    with style.style():
        figure = draw_page(list(_panels(frame, components)), rows_px / cols_px, headline, about)
        return style.save(figure, path)


def _panels(frame: Frame, components: Components) -> Iterator[Panel]:
    if frame.image is not None:
        yield Panel("image", partial(camera_panels.draw_image, frame=frame))
    for row, title in enumerate(("optical flow u", "planar flow û")):
        draw = partial(draw_mixture, frame=frame, components=components, row=row)
        yield Panel(title, draw)
    yield Panel("mixing", partial(draw_mixing, components=components))
    for which, kind in enumerate(("low variance", "high variance")):
        taken = ", taken" if which == components.taken else ""
        draw = partial(draw_component, frame=frame, components=components, which=which)
        yield Panel(f"{NAMES[which]}: {kind}{taken}", draw)
    if frame.plane is not None:
        yield Panel("score ε", partial(draw_score, frame=frame, plane=frame.plane))
        yield Panel("dominant plane", partial(camera_panels.draw_plane, frame=frame))


def mixture(components: Components, row: int) -> Doubles:
    """Return the flow (row 0) or the planar flow (row 1) that the components are mixed to, (rows, cols, 2), px."""
    of_alpha, of_beta = components.mixing[row]
    return np.asarray(of_alpha * components.alpha + of_beta * components.beta)


def draw_mixture(axes: Axes, frame: Frame, components: Components, row: int) -> str:
    """Draw the flow or the planar flow as a mixture; return its caption."""
    full = show_vectors(axes, frame, Field(mixture(components, row), components.valid, components.step_px))
    symbol = ("u", "û")[row]
    of_alpha, of_beta = components.mixing[row].tolist()
    said = ("as seen", "of a floor with nothing on it")[row]
    return f"{said}; full colour at {full:.1f} px;\n{symbol} = {_signed(of_alpha, of_beta)}"


def draw_component(axes: Axes, frame: Frame, components: Components, which: int) -> str:
    """Draw an independent component; return its caption."""
    field = (components.alpha, components.beta)[which]
    full = show_vectors(axes, frame, Field(field, components.valid, components.step_px))
    variance = float(components.variances[which])
    return f"of unit variance, full colour at {full:.1f};\nvariance of its length: {variance:.3g}"


def draw_mixing(axes: Axes, components: Components) -> str:
    """Draw the samples of both mixtures and the directions of the components; return the caption."""
    valid = components.valid != 0
    # All horizontal parts, then all vertical ones: points at a regular step are of both.
    planar, flow = (mixture(components, row)[valid].T.reshape(-1) for row in (1, 0))
    every = max(1, len(planar) // _MAX_POINTS)
    axes.axhline(0, color="#c8c8c8", lw=0.8, zorder=0)
    axes.axvline(0, color="#c8c8c8", lw=0.8, zorder=0)
    axes.scatter(planar[::every], flow[::every], s=7, color=_POINTS, alpha=0.35, linewidths=0, zorder=2)
    reach = 1.15 * max(float(np.percentile(np.abs(np.concatenate([planar, flow])), _CROWD_PERCENT)), 1e-3)
    box = axes.get_window_extent()
    shape = box.width / box.height
    axes.set_xlim(-reach * max(shape, 1.0), reach * max(shape, 1.0))
    axes.set_ylim(-reach / min(shape, 1.0), reach / min(shape, 1.0))
    for column, (name, colour) in enumerate(zip(NAMES, COLOURS, strict=True)):
        _direction(axes, components.mixing[::-1, column], reach, name, colour)
    axes.set_xticks([])
    axes.set_yticks([])
    for at, text, align in (((0.985, 0.515), "û", "right"), ((0.515, 0.98), "u", "left")):
        axes.text(
            *at,
            text,
            transform=axes.transAxes,
            ha=align,
            va="bottom" if align == "right" else "top",
            fontsize=10,
            color=style.QUIET,
            path_effects=style.halo(),
        )
    return "both parts of each vector, as points (û, u);\nalong a line only its component changes"


def _direction(axes: Axes, column: Doubles, reach: float, name: str, colour: str) -> None:
    """Draw the line along which one component alone moves the samples, (û, u)."""
    length = float(np.hypot(*column))
    if not length:
        return
    unit = column / length * (1.0 if column[1] >= 0 else -1.0)
    far = reach * 3 * unit
    axes.plot([-far[0], far[0]], [-far[1], far[1]], color=colour, lw=2.0, zorder=4)
    side = np.array([unit[1], -unit[0]])
    x, y = 0.62 * reach * unit + 0.13 * reach * side
    axes.text(
        x,
        y,
        name,
        color=colour,
        fontsize=13,
        ha="center",
        va="center",
        zorder=6,
        path_effects=style.halo(),
    )


def draw_score(axes: Axes, frame: Frame, plane: Plane) -> str:
    """Draw the score of every cell and the threshold; return the caption."""
    seen = plane.score[plane.valid != 0]
    top = max(float(np.percentile(seen, 99)) if len(seen) else 0.0, 1.2 * plane.threshold, 1e-6)
    extent = extent_px(plane.score.shape, plane.step_px)
    axes.imshow(plane.score, extent=extent, cmap="magma", vmin=0, vmax=top, interpolation="nearest", aspect="auto")
    hatch_unjudged(axes, plane)
    over_picture(axes, frame)
    return f"dark: 0, bright: {top:.2g} and more;\nobstacle above {plane.threshold:.2g}"


def _signed(of_alpha: float, of_beta: float) -> str:
    sign = "−" if of_beta < 0 else "+"
    return f"{of_alpha:.2f} {NAMES[0]} {sign} {abs(of_beta):.2f} {NAMES[1]}".replace("-", "−")
