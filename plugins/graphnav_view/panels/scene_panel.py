"""The scene panel: the robot and its surroundings from above, heading up."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Circle, Polygon
from matplotlib.transforms import Affine2D

from graphnav import Scene, State
from graphnav_view import style
from graphnav_view.maps.floorplan import draw_areas
from graphnav_view.track import Track

_MIN_HEIGHT_M, _MAX_HEIGHT_M = 2.0, 12.0
_VIEWS = 2.0
"""Height of the panel in reaches of the camera."""


@dataclass(frozen=True)
class SceneMoment:
    """The scene, the entire path, and the pose and time of the robot on it."""

    scene: Scene
    track: Track
    state: State
    time_s: float


def draw_scene(axes: Axes, moment: SceneMoment) -> str:
    """Draw the close-up of a scene; return its caption."""
    scene, state = moment.scene, moment.state
    x, y, yaw = state.x_m, state.y_m, state.yaw_rad
    to_axes = Affine2D().translate(-x, -y).rotate(math.pi / 2 - yaw)
    ahead, behind, half_width = _extent(axes, scene)
    axes.set_facecolor(style.FLOOR)
    seen = scene.seen_at(np.array([x, y, yaw]))
    draw_areas(axes, [*scene.fixed, *scene.moving_at(state.moving), *seen], to_axes)
    _draw_path(axes, moment, to_axes)
    radius = scene.robot_radius_m
    looks: dict[str, Any] = {"facecolor": "white", "edgecolor": style.ROBOT, "lw": 1.6, "zorder": 6}
    if scene.robot is None:
        axes.add_patch(Circle((0, 0), radius, **looks))
    else:
        axes.add_patch(Polygon(to_axes.transform(scene.robot.at(np.array([x, y, yaw])).outline_m), **looks))
    axes.annotate(
        "",
        (0, 2.4 * radius),
        (0, 0),
        zorder=7,
        arrowprops={"arrowstyle": "-|>", "color": style.ROBOT, "lw": 2.0, "shrinkA": 0, "shrinkB": 0},
    )
    axes.set_xlim(-half_width, half_width)
    axes.set_ylim(-behind, ahead)
    axes.set_xticks([])
    axes.set_yticks([])
    _scale_bar(axes, half_width, behind)
    return "from above, heading up; blue: the camera's view\nof the floor; line: path, dotted: still to come"


def _extent(axes: Axes, scene: Scene) -> tuple[float, float, float]:
    """Return metres shown ahead, behind, and to each side, in the shape of the axes."""
    reach = 1.0 if scene.seen is None else float(scene.seen.outline_m[:, 0].max())
    height = min(max(_VIEWS * reach, 8.0 * scene.robot_radius_m, _MIN_HEIGHT_M), _MAX_HEIGHT_M)
    box = axes.get_window_extent()
    behind = 0.36 * height
    return height - behind, behind, height * box.width / box.height / 2


def _draw_path(axes: Axes, moment: SceneMoment, to_axes: Affine2D) -> None:
    xy = to_axes.transform(moment.track.pose[:, :2])
    past = moment.track.time_s <= moment.time_s
    axes.plot(*xy[past].T, color=style.ROBOT, lw=2.0, zorder=4, solid_capstyle="round")
    axes.plot(*xy[~past].T, color=style.ROBOT, lw=1.4, ls=":", zorder=4)


def _scale_bar(axes: Axes, half_width: float, behind: float) -> None:
    length = next((m for m in (0.1, 0.2, 0.5, 1.0, 2.0, 5.0) if m >= 0.3 * half_width), 5.0)
    right, low = half_width * 0.93, -behind * 0.82
    axes.plot(
        [right - length, right],
        [low, low],
        color="black",
        lw=3,
        solid_capstyle="butt",
        zorder=9,
        path_effects=style.halo(6),
    )
    axes.text(
        right - length / 2,
        low + 0.05 * behind,
        f"{length:g} m",
        ha="center",
        va="bottom",
        fontsize=9,
        zorder=9,
        path_effects=style.halo(),
    )
