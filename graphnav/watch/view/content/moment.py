"""The messages for the details of one channel, and those of other channels with the same timestamp."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from graphnav.arrays import Doubles
from graphnav.core.record import Kind
from graphnav.watch.feed import Received, WatchedChannel
from graphnav.watch.view.page_feed import PageState


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
