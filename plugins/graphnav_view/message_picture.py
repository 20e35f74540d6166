"""Draw a single message for viewers of live channels and logs."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from graphnav import (
    Components,
    Flow,
    Image,
    LocalMap,
    Map,
    Message,
    Planar,
    Plane,
    Potential,
    Scan,
    Scene,
    State,
    Steering,
    Truth,
)
from graphnav.arrays import Bytes, Floats
from graphnav_view.flow_colour import flow_scale_px
from graphnav_view.maps.local_map import draw_local_map
from graphnav_view.maps.scan import draw_scan
from graphnav_view.video.camera_tiles import Stretch, camera_rgb, camera_tile, flow_tile, plane_tile, potential_tile
from graphnav_view.video.map_tile import TopView, view_size_px

if TYPE_CHECKING:
    from graphnav import PictureContext


_LEGEND_ROWS, _LEGEND_COLS = 160, 200
"""Minimum size of a picture with text."""
_SAME_VIEW_RATIO = 1.25
"""Maximum difference of the sides of grids of the same view."""
_UNKNOWN_LEVEL = 0.4
"""Brightness of an unknown cell where there is no colour; an obstacle has 1."""
_MAX_BODIES = 2000
_MAX_M = 1e6
_MIN_SCALE = 1e-6


def picture_of(message: Message, context: PictureContext) -> Bytes | None:
    """Return the picture of a message that fits the context's box, None for a type that has none.

    Raises ValueError for a message that cannot be drawn: a map without extent or with numbers that are not finite.
    """
    draw = next((draw for kind, draw in _DRAWN.items() if isinstance(message, kind)), None)
    if draw is None:
        return None
    with np.errstate(all="ignore"):
        return draw(message, context)


def _image(image: Image, context: PictureContext) -> Bytes:
    return camera_rgb(_stretch(image.pixels.shape, context), _at_step_1(image))


def _flow(flow: Flow, context: PictureContext) -> Bytes:
    return _flow_colours(flow.uv_px, flow.valid, context)


def _planar(planar: Planar, context: PictureContext) -> Bytes:
    return _flow_colours(planar.planar_uv_px, planar.planar_valid, context)


def _components(components: Components, context: PictureContext) -> Bytes:
    """Draw the component that the score is made from."""
    taken = components.beta if components.taken else components.alpha
    return _flow_colours(taken, components.valid, context)


def _flow_colours(uv_px: Floats, valid: npt.NDArray[Any], context: PictureContext) -> Bytes:
    """Draw a flow as colours; values that are not finite are not valid."""
    stretch = _stretch(valid.shape, context)
    seen = (valid != 0) & np.isfinite(uv_px).all(axis=-1)
    flow = Flow(np.where(seen[..., None], uv_px, 0).astype(np.float32), seen.astype(np.uint8), 0)
    if not context.with_colour:
        return _gray(stretch, np.linalg.norm(flow.uv_px.astype(np.float64), axis=-1))
    return flow_tile(stretch, flow, flow_scale_px(flow.uv_px, flow.valid), with_wheel=_has_room(stretch, context))


def _plane(plane: Plane, context: PictureContext) -> Bytes:
    return _obstacle(plane.obstacle, plane.valid, plane.step_px, context)


def _truth(truth: Truth, context: PictureContext) -> Bytes:
    return _obstacle(truth.obstacle, np.ones_like(truth.obstacle), truth.step_px, context)


def _obstacle(obstacle: npt.NDArray[Any], valid: npt.NDArray[Any], step_px: int, context: PictureContext) -> Bytes:
    """Draw a dominant map over the image of its moment, alone if there is none of the same view."""
    image = context.find(Image)
    camera = None
    nothing = np.empty((0, 0), np.float32)
    plane = Plane(obstacle, nothing, valid, step_px=step_px, obstacle_ratio=0.0)
    if not context.with_colour:
        return _gray(_stretch(obstacle.shape, context), (obstacle != 0) + _UNKNOWN_LEVEL * plane.unknown(), 1.0)
    if image is None or not _is_same_view(obstacle.shape, step_px, image):
        step_px = 1
        stretch = _stretch(obstacle.shape, context)
    else:
        rows, cols = obstacle.shape
        stretch = _stretch((rows * step_px, cols * step_px), context)
        camera = camera_rgb(stretch, image)
    return plane_tile(stretch, camera, replace(plane, step_px=step_px), with_legend=_has_room(stretch, context))


def _gray(stretch: Stretch, values: npt.NDArray[Any], white: float = _MIN_SCALE) -> Bytes:
    """Draw a grid of numbers as brightness: 0 black, the largest, at least ``white``, white."""
    levels = (255 * (values / values.max(initial=white))).astype(np.uint8)
    return stretch.placed(np.repeat(stretch.resized(levels, 1)[..., None], 3, axis=-1))


def _potential(potential: Potential, context: PictureContext) -> Bytes:
    values = potential.potential
    finite = np.isfinite(values)
    low = values[finite].min() if finite.any() else 0.0
    drawn = Potential(np.where(finite, values, low), potential.gradient, step_px=1)
    return potential_tile(_stretch(values.shape, context), drawn)


def _steering(steering: Steering, context: PictureContext) -> Bytes | None:
    """Draw the control force over the image of its moment; None if there is none."""
    image = context.find(Image)
    if image is None:
        return None
    _require_finite(steering)
    stretch = _stretch(image.pixels.shape, context)
    width = max(1, min(stretch.rows, stretch.cols) // 80)
    return camera_tile(stretch, camera_rgb(stretch, _at_step_1(image)), steering, width)


def _map(world: Map, context: PictureContext) -> Bytes:
    return _from_above(world, context.find(State), context)


def _state(state: State, context: PictureContext) -> Bytes | None:
    """Draw the robot on its map; None without a map."""
    world = context.find(Map)
    return None if world is None else _from_above(world, state, context)


def _local_map(local: LocalMap, context: PictureContext) -> Bytes:
    _require_finite(local)
    stretch = _stretch(local.state.shape, context)
    return draw_local_map(local, stretch.rows, stretch.cols, with_colour=context.with_colour)


def _scan(scan: Scan, context: PictureContext) -> Bytes:
    _require_finite(scan)
    side = max(1, min(context.rows, context.cols))
    return draw_scan(scan, side, with_scale=context.with_legend and side >= _LEGEND_ROWS)


def _from_above(world: Map, state: State | None, context: PictureContext) -> Bytes:
    _require_finite(world)
    if len(world.kind) > _MAX_BODIES:
        raise ValueError(f"a map of {len(world.kind)} bodies: at most {_MAX_BODIES} are drawn")
    path_m = np.empty((0, 2))
    moving = np.empty((0, 0, 3))
    if state is not None:
        _require_finite(state)
        path_m = context.path_m()
        path_m = np.vstack([path_m[np.abs(path_m).max(axis=1, initial=0) <= _MAX_M], [[state.x_m, state.y_m]]])
        moving = state.moving[None]
    scene = Scene(world)
    cols, rows = view_size_px(scene, path_m, moving, context.cols, context.rows)
    with_scale = context.with_legend and rows >= _LEGEND_ROWS and cols >= _LEGEND_COLS
    view = TopView(scene, path_m, moving, cols, rows, with_scale=with_scale)
    return view.draw(state, path_m)


_DRAWN: Mapping[type[Message], Callable[[Any, PictureContext], Bytes | None]] = {
    Image: _image,
    Flow: _flow,
    Planar: _planar,
    Components: _components,
    Plane: _plane,
    Truth: _truth,
    Potential: _potential,
    Steering: _steering,
    Map: _map,
    State: _state,
    LocalMap: _local_map,
    Scan: _scan,
}


def _stretch(shape: tuple[int, ...], context: PictureContext) -> Stretch:
    """Return the scaling of grids of a shape into the box, without margins."""
    rows, cols = shape[:2]
    if not rows or not cols:
        raise ValueError(f"a grid of {rows} x {cols} cells is empty")
    scale = min(context.rows / rows, context.cols / cols)
    return Stretch(rows, cols, max(1, round(rows * scale)), max(1, round(cols * scale)))


def _at_step_1(image: Image) -> Image:
    """Return an image as if it had one pixel per cell; only its shape matters."""
    return Image(image.pixels)


def _has_room(stretch: Stretch, context: PictureContext) -> bool:
    return context.with_legend and stretch.rows >= _LEGEND_ROWS and stretch.cols >= _LEGEND_COLS


def _is_same_view(shape: tuple[int, ...], step_px: int, image: Image) -> bool:
    """Whether a grid and an image cover the same pixels, except for cells at the border."""
    pairs = zip(shape[:2], image.pixels.shape[:2], strict=True)
    ratios = [(mine * step_px) / max(theirs * image.step_px, 1) for mine, theirs in pairs]
    return all(1 / _SAME_VIEW_RATIO < ratio < _SAME_VIEW_RATIO for ratio in ratios)


def _require_finite(message: Message) -> None:
    """Raise ValueError for a message with numbers that cannot be drawn."""
    name = message.not_finite()
    if name is not None:
        raise ValueError(f"{name} is not finite")
    for name in ("vertices_m", "goal_m", "footprint_m", "moving", "x_m", "y_m"):
        value = np.asarray(getattr(message, name, 0.0))
        if value.size and np.abs(value).max() > _MAX_M:
            raise ValueError(f"{name} lies more than {_MAX_M:g} m away")
