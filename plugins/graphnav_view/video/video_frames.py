"""The frames of ``video.mp4``: camera, flow, dominant plane and map side by side, time and steering angle below."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from collections.abc import Set as AbstractSet
from typing import Any

import numpy as np

from graphnav import Flow, Image, Map, Plane, Potential, Scene, State, Steering, Twist, VideoFrames
from graphnav.arrays import Bytes
from graphnav_view.flow_colour import flow_scale_px
from graphnav_view.signals import Signals
from graphnav_view.track import is_placed, track_of
from graphnav_view.video.camera_tiles import Stretch, camera_rgb, camera_tile, flow_tile, plane_tile, potential_tile
from graphnav_view.video.lettering import write
from graphnav_view.video.map_tile import TopView

Messages = Mapping[type, Any]

_TILE_COLS = 480
_MIN_TILE_ROWS, _MAX_TILE_ROWS = 240, 480
_HEAD_PX, _FOOT_PX, _GAP_PX = 26, 34, 4
_PAGE, _INK, _FAINT = (24, 26, 30), (240, 240, 240), (170, 174, 180)
_KINDS = (Image, Flow, Plane, Potential, Steering, Twist, State)
_PERIOD_US = 1e5
"""Of a log with a single image."""
_SCALE_FRAMES = 25
"""Frames that the flow's colour scale is taken from."""


def video_frames(signals: Signals, from_s: float = -math.inf, until_s: float = math.inf) -> VideoFrames | None:
    """Return the video's frames at the rate of the camera; None where the log has no images in that span.

    ``from_s``, ``until_s``: seconds from the start of the log, both included.
    """
    stamps = signals.stamps(Image)
    shown = {utime for utime in stamps if from_s <= signals.at_s(utime) <= until_s}
    if not shown:
        return None
    period_us = float(np.median(np.diff(stamps))) if len(stamps) > 1 else _PERIOD_US
    return VideoFrames(1e6 / max(period_us, 1.0), len(shown), _frames(signals, shown))


def _frames(signals: Signals, shown: AbstractSet[int]) -> Iterator[tuple[int, Bytes]]:
    """Yield the frames of some stamps with their stamps, (rows, cols, 3) RGB, both even.

    The last tile is drawn from the start of the run, so that its path is complete.
    """
    image = signals.first(Image)
    assert image is not None
    picture_rows, picture_cols = (n * image.step_px for n in image.pixels.shape[:2])
    tile_rows = round(min(max(_TILE_COLS * picture_rows / picture_cols, _MIN_TILE_ROWS), _MAX_TILE_ROWS) / 2) * 2
    tiles = _tiles(signals, Stretch(picture_rows, picture_cols, tile_rows, _TILE_COLS))
    page = _Page([title for title, _ in tiles], tile_rows, _TILE_COLS)
    last = max(shown)
    for utime, messages in signals.joined(*_KINDS):
        if utime > last:
            return
        of = dict(zip(_KINDS, messages, strict=True))
        drawn = [draw(of) for _, draw in (tiles if utime in shown else tiles[-1:])]
        if utime in shown:
            yield utime, page.draw(drawn, caption(utime - signals.begin_us, of))


def _tiles(signals: Signals, stretch: Stretch) -> list[tuple[str, Callable[[Messages], Bytes]]]:
    """Return titles and what draws the tiles of a frame, given its messages by type."""
    there = {kind for kind in _KINDS if signals.channel(kind) is not None}
    found: list[tuple[str, Callable[[Messages], Bytes]]] = [
        (
            "camera, control force" if Steering in there else "camera",
            lambda of: camera_tile(stretch, camera_rgb(stretch, of[Image]), of[Steering]),
        )
    ]
    if Flow in there:
        full_px = _full_px(signals)
        found.append(("optical flow", lambda of: flow_tile(stretch, of[Flow], full_px)))
    if Plane in there:
        found.append(
            (
                "dominant plane: obstacle red",
                lambda of: plane_tile(stretch, camera_rgb(stretch, of[Image]), of[Plane]),
            )
        )
    world, track = signals.first(Map), track_of(signals)
    if world is not None and track is not None:
        view = TopView(Scene(world), track.pose[:, :2], track.moving, *stretch.tile_size_px)
        found.append(("map from above", _Drive(view).draw))
    elif Potential in there:
        found.append(("obstacle potential", lambda of: potential_tile(stretch, of[Potential])))
    return found


def _full_px(signals: Signals) -> float:
    """Return the flow that is drawn in full colour: the median over frames spread over the run."""
    stamps = signals.stamps(Flow)
    every = max(1, len(stamps) // _SCALE_FRAMES)
    scales = []
    for utime in stamps[::every]:
        flow = signals.at(Flow, utime)
        if flow is not None:
            scales.append(flow_scale_px(flow.uv_px, flow.valid))
    return float(np.median(scales)) if scales else 1.0


def caption(time_us: int, of: Messages) -> list[str]:
    """Return the words below a frame, from its messages by type; what rounds to zero has no minus."""
    words = [f"t = {time_us / 1e6:6.2f} s"]
    steering, plane, twist, state = of[Steering], of[Plane], of[Twist], of[State]
    if steering is not None:
        words.append(f"theta = {math.degrees(steering.theta_rad):+z4.0f} deg")
    if plane is not None:
        words.append(f"obstacle {100 * plane.obstacle_ratio:3.0f} %")
    if twist is not None:
        words += [f"v = {twist.v_mps:z.2f} m/s", f"omega = {twist.omega_radps:+z.2f} rad/s"]
    if state is not None and state.contact:
        words[-1:] = ["CONTACT"]
    return words


class _Drive:
    """The map's tile, with the path through all states so far."""

    def __init__(self, view: TopView) -> None:
        self._view = view
        self._path: list[tuple[float, float]] = []

    def draw(self, of: Messages) -> Bytes:
        """Return the tile of a frame; the robot is missing where its pose is not finite."""
        state = of[State]
        if state is not None and not is_placed(state):
            state = None
        if state is not None:
            self._path.append((state.x_m, state.y_m))
        return self._view.draw(state, np.array(self._path))


class _Page:
    """Frames of tiles in two columns (three tiles: in one row), titles above, the caption below."""

    def __init__(self, titles: Sequence[str], rows: int, cols: int) -> None:
        self._columns = len(titles) if len(titles) in (1, 3) else 2
        self._rows, self._cols = rows, cols
        lines = -(-len(titles) // self._columns)
        height = lines * (rows + _HEAD_PX + _GAP_PX) + _FOOT_PX
        self._empty = np.full((height, self._columns * (cols + _GAP_PX) + _GAP_PX, 3), _PAGE, np.uint8)
        for place, title in enumerate(titles):
            top, left = self._corner(place)
            write(self._empty, title, (left + 4, top - 8), _INK)

    def draw(self, tiles: Sequence[Bytes], words: Sequence[str]) -> Bytes:
        """Return a frame, (rows, cols, 3) RGB."""
        page = self._empty.copy()
        for place, tile in enumerate(tiles):
            top, left = self._corner(place)
            page[top : top + self._rows, left : left + self._cols] = tile
        for place, word in enumerate(words):
            at = (8 + place * (page.shape[1] - 16) // 5, page.shape[0] - 12)
            write(page, word, at, _INK if place < 2 else _FAINT)
        return page

    def _corner(self, place: int) -> tuple[int, int]:
        line, column = divmod(place, self._columns)
        return line * (self._rows + _HEAD_PX + _GAP_PX) + _HEAD_PX, column * (self._cols + _GAP_PX) + _GAP_PX
