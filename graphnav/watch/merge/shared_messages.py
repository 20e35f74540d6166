"""Find the messages that two logs hold, and which of the two hosts sent them."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from functools import cached_property
from hashlib import blake2b
from typing import NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from graphnav import About, GraphnavError, Recording, Status, UserError
from graphnav.core.codec import DecodeError, decode
from graphnav.core.spec import outline_of
from graphnav.watch.channel_account import kind_of
from graphnav.watch.merge.clock_offset import Ints, SharedMessages

M = TypeVar("M", About, Status)

_MAX_TIME_US = 1 << 62
_MAX_CHANNELS_OF_ONE = 4
"""A payload on more channels of a log than this tells nothing."""


class Way(NamedTuple):
    """The messages of a channel that another log holds, on a channel of any name.

    ``way``: 1 if the host of the first log sent them, -1 if that of the other one did, 0 if that is not known.
    ``took_us``: how much later the receiver logged each, by one clock; the other one if the sender is not known.
    """

    channel: str
    other_channel: str
    way: int
    took_us: Ints


class _Run(NamedTuple):
    """The content of a description: whether its run made (true) or received (false) the messages of a channel."""

    run_id: str
    made: Mapping[str, bool]


class LogMessages:
    """The messages of one log: when they were logged, and their digests.

    ``at_us``: the timestamps of all events by the log's own clock, non-decreasing: those that jump are corrected.
    ``first_us``: the same by the clock of the first log, once that is known.

    Raises
    ------
    GraphnavError
        The log is empty, or its timestamps are beyond all clocks.
    """

    def __init__(self, recording: Recording, sent: Collection[str] = ()) -> None:
        self.recording = recording
        self._sent = sent
        if not recording.n_events:
            raise GraphnavError(f"{recording.path} is empty")
        since_us = np.array(recording.timeline.at_us, np.int64)
        self.logged_us = np.fromiter((entry.utime for entry in recording.entries()), np.int64, len(since_us))
        begins_us = np.sort(self.logged_us - since_us)
        self.at_us: Ints = since_us + begins_us[len(begins_us) // 2]
        if not 0 <= self.at_us[0] <= self.at_us[-1] < _MAX_TIME_US:
            raise GraphnavError(
                f"{recording.path}: its timestamps are not those of a clock, from {self.logged_us[0]} us"
            )
        self.first_us: Ints = self.at_us
        digests = (blake2b(event.data, digest_size=8).digest() for event in recording.events())
        self.digests: NDArray[np.uint64] = np.frombuffer(b"".join(digests), np.uint64)
        self.channels = list(recording.index.channels)

    @cached_property
    def run_ids(self) -> frozenset[str]:
        """The ids of the runs that announce themselves or tell their status."""
        told = (status.run_id for status in self._decoded(Status))
        return frozenset(filter(None, (*(run.run_id for run in self._runs), *told)))

    @cached_property
    def own_id(self) -> str:
        """The id of the run that wrote the log itself, empty if a logger did, or it is not known."""
        is_own = any(not run.run_id for run in self._runs)
        return next((status.run_id for status in self._decoded(Status)), "") if is_own else ""

    def has_made(self, channel: str, other: LogMessages) -> tuple[bool | None, bool]:
        """Return whether the log's host made (true) or received (false) a channel's messages, None if not known.

        And whether that is from the run that wrote it. What another run that both logs hear says is of neither host.
        """
        if channel in self._sent:
            return True, True
        for run in self._runs:
            if channel in run.made and (not run.run_id or run.run_id not in other.run_ids):
                return run.made[channel], not run.run_id
        return None, False

    @cached_property
    def _runs(self) -> Sequence[_Run]:
        found = [_Run(about.run_id, _made(about)) for about in self.abouts()]
        return sorted({run.run_id: run for run in found}.values(), key=lambda run: bool(run.run_id))

    def abouts(self) -> Iterator[About]:
        """Yield the descriptions of runs."""
        return (about for about in self._decoded(About) if about.channels)

    def digests_of(self, channel: str) -> NDArray[np.uint64]:
        """Return the digests of a channel's messages."""
        return self.digests[np.array(self.recording.index.channels[channel], np.int64)]

    def _decoded(self, message: type[M]) -> Iterator[M]:
        for index in range(self.recording.count(message.CHANNEL)):
            try:
                yield decode(message, self.recording.event(message.CHANNEL, index).data)[2]
            except DecodeError:
                continue

    @cached_property
    def _stamped(self) -> frozenset[str]:
        """The channels whose messages begin with stamp and number."""
        kinds = {name: kind_of(self.recording.event(name, 0).data) for name in self.channels}
        return frozenset(name for name, kind in kinds.items() if kind is not None and kind.is_stamped)

    @cached_property
    def single(self) -> tuple[NDArray[np.uint64], Ints, Ints]:
        """The digests that occur once on a channel, sorted, with their events and channels (by place)."""
        digests, numbers, channels = [], [], []
        for place, name in enumerate(self.channels):
            if name == About.CHANNEL:
                continue
            of_channel = np.array(self.recording.index.channels[name], np.int64)
            found, first, counts = np.unique(self.digests[of_channel], return_index=True, return_counts=True)
            digests.append(found[counts == 1])
            numbers.append(of_channel[first[counts == 1]])
            channels.append(np.full(len(numbers[-1]), place))
        if not digests:
            return np.empty(0, np.uint64), np.empty(0, np.int64), np.empty(0, np.int64)
        order = np.argsort(all_digests := np.concatenate(digests), kind="stable")
        return all_digests[order], np.concatenate(numbers)[order], np.concatenate(channels)[order]

    def is_told_apart(self, channel: str, other: LogMessages, other_channel: str) -> bool:
        """Whether equal messages of two channels are one: they are numbered and stamped, or the channel is the same."""
        return channel == other_channel or (channel in self._stamped and other_channel in other._stamped)


def _made(about: About) -> dict[str, bool]:
    """Return for each channel of a run whether it makes its messages."""
    try:
        spec = outline_of(about.graph_yaml.encode("utf-8", "replace"), About.CHANNEL)
    except UserError:
        return {}
    received = set[str]()
    for ref, source in spec.inputs.items():
        renamed = spec.channels.get(ref)
        received |= {ref if renamed is None else str(renamed.value.data), source.channel_name}
    return {channel: channel not in received for channel in about.channels}


class Found(NamedTuple):
    """The messages that two logs hold: for the clocks, and by channel."""

    messages: SharedMessages
    pairs: Sequence[tuple[str, str, int, Ints, Ints]]
    """Channel of the first and of the other log, way, events there and here."""

    def ways(self, first: LogMessages, other: LogMessages) -> list[Way]:
        """Return how long the messages took, once both logs have one clock."""
        return [
            Way(channel, other_channel, way, (other.first_us[theirs] - first.first_us[ours]) * (-1 if way < 0 else 1))
            for channel, other_channel, way, ours, theirs in self.pairs
        ]


def find_shared(first: LogMessages, other: LogMessages) -> Found | None:
    """Return the messages that both logs hold, None without any; ``first`` is on the first log's clock."""
    ours, theirs = _matched(first, other)
    place = first.single[2][ours] * len(other.channels) + other.single[2][theirs]
    pairs: list[tuple[str, str, int, Ints, Ints]] = []
    for one in np.unique(place):
        channel = first.channels[int(one) // len(other.channels)]
        other_channel = other.channels[int(one) % len(other.channels)]
        if first.is_told_apart(channel, other, other_channel):
            chosen = place == one
            numbers = first.single[1][ours[chosen]], other.single[1][theirs[chosen]]
            pairs.append((channel, other_channel, _way(first, channel, other, other_channel), *numbers))
    if not pairs:
        return None
    here, there = (np.concatenate([pair[side] for pair in pairs]) for side in (3, 4))
    ways = np.concatenate([np.full(len(pair[3]), pair[2]) for pair in pairs])
    order = np.argsort(there, kind="stable")
    here, there, ways = here[order], there[order], ways[order]
    ahead_us = other.at_us[there] - first.first_us[here]
    return Found(SharedMessages(there, other.at_us[there], ahead_us, ways), pairs)


def _matched(first: LogMessages, other: LogMessages) -> tuple[Ints, Ints]:
    """Return the places of equal digests in what is `LogMessages.single`, without those on many channels."""
    ours, theirs = first.single[0], other.single[0]
    begin, end = np.searchsorted(ours, theirs, "left"), np.searchsorted(ours, theirs, "right")
    own = np.searchsorted(theirs, theirs, "right") - np.searchsorted(theirs, theirs, "left")
    counts = np.where((end - begin > _MAX_CHANNELS_OF_ONE) | (own > _MAX_CHANNELS_OF_ONE), 0, end - begin)
    right = np.repeat(np.arange(len(theirs)), counts)
    within = np.arange(len(right)) - np.repeat(np.cumsum(counts) - counts, counts)
    return np.repeat(begin, counts) + within, right


def _way(first: LogMessages, channel: str, other: LogMessages, other_channel: str) -> int:
    """Return which host sent the messages of two channels: 1 the first one, -1 the other one, 0 unknown."""
    (ours, is_our_run), (theirs, is_their_run) = first.has_made(channel, other), other.has_made(other_channel, first)
    if ours and theirs:
        return is_our_run - is_their_run
    return 1 if ours else -1 if theirs else 0
