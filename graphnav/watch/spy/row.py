"""One row of the table: the statistics of a channel."""

from __future__ import annotations

from dataclasses import dataclass

from graphnav.watch.feed import WatchedChannel


@dataclass(frozen=True)
class Row:
    """The statistics of one channel; unknown values are None.

    ``rate_hz``: by timestamps. ``min_s`` to ``std_s``: of their periods. ``n_bytes``: of the newest message.
    ``transport_s``: the transport age, from stamp to arrival. ``drops``: gaps in the sequence numbers. ``age_s``: since
    the newest message arrived. ``counts``: messages in each of the last seconds, oldest first.
    """

    name: str
    type_name: str | None
    messages: int
    rate_hz: float | None
    min_s: float | None
    mean_s: float | None
    max_s: float | None
    std_s: float | None
    bytes_per_s: float | None
    n_bytes: int | None
    transport_s: float | None
    drops: int
    undecodable: int
    age_s: float | None
    is_stale: bool
    counts: tuple[int, ...]


def row_of(channel: WatchedChannel, now_s: float, clock_offset_s: float, age_s: float | None) -> Row:
    """Return the row of a channel at ``now_s`` on the arrival clock; ``age_s``: of its newest message."""
    periods = channel.published
    return Row(
        name=channel.name,
        type_name=channel.type_name,
        messages=channel.count,
        rate_hz=periods.rate_hz if periods else None,
        min_s=periods.min_s if periods else None,
        mean_s=periods.mean_s if periods else None,
        max_s=periods.max_s if periods else None,
        std_s=periods.std_s if periods else None,
        bytes_per_s=channel.bytes_per_s,
        n_bytes=channel.last_bytes if channel.count else None,
        transport_s=channel.transport_age_s(clock_offset_s),
        drops=channel.lost,
        undecodable=channel.undecodable,
        age_s=age_s,
        is_stale=channel.is_silent,
        counts=tuple(channel.rates.counts(now_s)),
    )
