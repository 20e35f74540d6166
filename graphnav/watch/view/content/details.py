"""Details of the open channel's newest message: fields, plot, values under the cursor, picture."""

from __future__ import annotations

import io
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np

from graphnav import Message, PictureContext
from graphnav.arrays import Bytes, Doubles
from graphnav.core.codec import DecodeError, decode, message_class_of
from graphnav.core.field_summary import summarised
from graphnav.core.pictures import Pictures
from graphnav.watch.channel_account import Kind
from graphnav.watch.feed import Received, WatchedChannel
from graphnav.watch.fields.plain_values import plain
from graphnav.watch.view.page_feed import PageState

M = TypeVar("M", bound=Message)
_ROWS, _COLS = 480, 640
_MAX_SERIES = 12
_MAX_VALUES = 4
_NOT_PLOTTED = {"utime", "seq", "interval_us", "step_px", "rows", "cols", "channels", "size"}
"""The envelope and the sizes of arrays."""


@dataclass(frozen=True)
class Moment:
    """The newest message of a channel and its type, and the messages to plot.

    ``others``: one message per LCM type, with the same timestamp if there is one, for combined pictures. ``path_m``:
    the robot's path, (n, 2).
    """

    kind: Kind
    newest: Received
    points: list[Received]
    others: Mapping[type, bytes]
    path_m: Doubles


def moment_of(state: PageState, channel: WatchedChannel, run_id: str | None, after: int) -> Moment | None:
    """Return the messages of a channel, with the points after message ``after``; None if nothing can be shown.

    The others are those of the run ``run_id``.
    """
    if channel.kind is None or channel.newest is None:
        return None
    points = [received for number, received in channel.history if number > after]
    if not channel.history and channel.count > after:
        points = [channel.newest]
    stamp = _stamp(channel)
    others: dict[type, bytes] = {}
    for other in state.channels_of(run_id).values():
        if other.kind is None or other.newest is None:
            continue
        if other.kind.lcm_class not in others or _stamp(other) == stamp:
            others[other.kind.lcm_class] = other.newest.data
    path_m = np.array(state.track_of(run_id).points_m, np.float64).reshape(-1, 2)
    return Moment(channel.kind, channel.newest, points, others, path_m)


def _stamp(channel: WatchedChannel) -> int | None:
    """Return the timestamp of the newest stored message."""
    if channel.kind is None or channel.newest is None:
        return None
    stamped = channel.kind.stamp(channel.newest.data)
    return None if stamped is None else stamped[0]


@dataclass(frozen=True)
class Cursor:
    """The position of the cursor on a picture, as fractions of its width and height."""

    x_ratio: float
    y_ratio: float


def details_of(moment: Moment, cursor: Cursor | None) -> dict[str, Any] | None:
    """Return fields, plotted points and values under the cursor; None if the newest message cannot be decoded."""
    values = _fields(moment.kind, moment.newest)
    if values is None:
        return None
    series = _series(values)
    points = []
    for received in moment.points:
        if (found := _fields(moment.kind, received)) is not None:
            plotted = _series(found)
            points.append([received.at_s, *(plotted.get(name) for name in series)])
    return {
        "fields": plain(summarised(values)),
        "series": list(series),
        "points": points,
        "has_cells": bool(getattr(message_class_of(moment.kind.lcm_class), "grid", ())),
        "under_cursor": _under_cursor(moment, cursor) if cursor else None,
    }


def picture_of(moment: Moment, pictures: Pictures) -> bytes | None:
    """Return the newest message as PNG; None if no plugin draws its type.

    Raises GraphnavError if it cannot be drawn.
    """
    message = _message(moment.kind, moment.newest)
    if message is None:
        return None

    def find(kind: type[M], /) -> M | None:
        held = (moment.others.get(lcm_class) for lcm_class in (kind.lcm_class, *kind.former_lcm_classes))
        data = next(filter(None, held), None)
        try:
            return None if data is None else decode(kind, data)[2]
        except DecodeError:
            return None

    picture = pictures.draw(message, PictureContext(_ROWS, _COLS, find, lambda: moment.path_m))
    return None if picture is None else _png(picture)


def _fields(kind: Kind, received: Received) -> dict[str, Any] | None:
    try:
        return kind.codec.decode(received.data)
    except DecodeError:
        return None


def _message(kind: Kind, received: Received) -> Message | None:
    message_class = message_class_of(kind.lcm_class)
    try:
        return None if message_class is None else decode(message_class, received.data)[2]
    except DecodeError:
        return None


def _series(values: Mapping[str, Any]) -> dict[str, float]:
    """Return the plotted numbers: scalars, and the elements of small arrays."""
    series: dict[str, float] = {}
    for name, value in values.items():
        if name in _NOT_PLOTTED or name.startswith("n_"):
            continue
        if isinstance(value, int | float) and not isinstance(value, bool):
            series[name] = float(value)
        elif isinstance(value, np.ndarray) and value.dtype != object and value.ndim == 1 and len(value) <= _MAX_VALUES:
            series |= {f"{name}[{place}]": float(number) for place, number in enumerate(value)}
        if len(series) >= _MAX_SERIES:
            break
    return series


def _under_cursor(moment: Moment, cursor: Cursor) -> dict[str, Any] | None:
    """Return the grid cell under the cursor, and its values."""
    message = _message(moment.kind, moment.newest)
    grids = {name: getattr(message, name) for name in message.grid} if message else {}
    if not grids:
        return None
    rows, cols = next(iter(grids.values())).shape[:2]
    row, col = int(cursor.y_ratio * rows), int(cursor.x_ratio * cols)
    step_px = getattr(message, "step_px", 1)
    values = {
        name: np.asarray(grid[row, col], np.float64).reshape(-1)[:_MAX_VALUES].tolist()
        for name, grid in grids.items()
        if row < grid.shape[0] and col < grid.shape[1]
    }
    return {"x_px": col * step_px, "y_px": row * step_px, "values": values}


def _png(picture: Bytes) -> bytes:
    from PIL import Image as Pillow

    out = io.BytesIO()
    Pillow.fromarray(picture).save(out, "PNG", compress_level=1)
    return out.getvalue()
