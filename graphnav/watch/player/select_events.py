"""Select the events of a log to play."""

from __future__ import annotations

from array import array
from bisect import bisect_left
from typing import NamedTuple

from graphnav.core.errors import GraphnavError, Place, UserError, did_you_mean, shown_name
from graphnav.core.record import ChannelFilter, Recording


class EventSelection(NamedTuple):
    """The numbers of the events, their times, and the selected time range (microseconds)."""

    numbers: array[int]
    at_us: array[int]
    channels: frozenset[str]
    begin_us: int
    end_us: int

    def first_at(self, time_us: float) -> int:
        """Return the index of the first event at or after a time."""
        return bisect_left(self.at_us, time_us)


def select_events(
    recording: Recording, channels: ChannelFilter, start_s: float = 0.0, end_s: float | None = None
) -> EventSelection:
    """Return the events on the channels from ``start_s`` to ``end_s`` (None: the end), seconds since the first event.

    Raises
    ------
    UserError
        The selection is empty, or the range is outside the log.
    GraphnavError
        The log is empty.
    """
    if not recording.n_events:
        why = f"; {recording.truncated}" if recording.truncated else ""
        raise GraphnavError(f"{recording.path} holds no messages{why}")
    times = recording.timeline.at_us
    duration_s = times[-1] / 1e6
    if start_s > duration_s:
        raise UserError.of(f"{start_s:g} s is after the end: the log is {duration_s:g} s long", "", Place("--start"))
    if end_s is not None and end_s < start_s:
        raise UserError.of(f"{end_s:g} s is before --start {start_s:g}", "give a later end", Place("--end"))
    begin_us, end_us = round(start_s * 1e6), times[-1] if end_s is None else min(times[-1], round(end_s * 1e6))
    numbers, at_us, taken = array("q"), array("q"), set[str]()
    for number, entry in enumerate(recording.entries()):
        if begin_us <= times[number] <= end_us and channels.takes(entry.channel):
            numbers.append(number)
            at_us.append(times[number])
            taken.add(entry.channel)
    if not numbers:
        raise _nothing(recording, channels)
    return EventSelection(numbers, at_us, frozenset(taken), begin_us, end_us)


def _nothing(recording: Recording, channels: ChannelFilter) -> UserError:
    names = {entry.channel for entry in recording.entries()}
    if any(map(channels.takes, names)):
        return UserError.of(
            f"{recording.path} holds no selected messages in this time range", "give another --start or --end"
        )
    known = {shown_name(name) for name in names}
    guesses = (did_you_mean(pattern, known) for pattern in channels.patterns)
    hint = next(filter(None, guesses), f"channels are {', '.join(sorted(known))}")
    return UserError.of(f"{recording.path} holds no channel that matches the filters", hint)
