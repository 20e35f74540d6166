"""The messages of a log by channel, and its damage."""

from __future__ import annotations

import itertools
from collections import defaultdict
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from graphnav import About, Graph, Recording, UserError
from graphnav.core.codec import codec_of
from graphnav.core.graph import RESERVED, Channel
from graphnav.core.record import Head

_MAX_TOLD = 5


class Logged(NamedTuple):
    """A message of a log: its position, timestamp and sequence number.

    ``at_us``: the time of publication by the run's clock, which equals the timestamp in lockstep.
    """

    channel: str
    place: int
    """The index within the channel."""
    utime: int
    seq: int
    n_bytes: int
    at_us: int


@dataclass(frozen=True)
class Contents:
    """The messages of a log on the channels of its graphs: of the replay, and of the run."""

    messages: Mapping[str, tuple[Logged, ...]]
    """Messages by channel, in file order; includes every channel of the graphs."""
    order: tuple[Logged, ...]
    """All messages in file order."""
    other_types: frozenset[str]
    """Channels with another type in the log."""
    lost: tuple[str, ...]
    """Descriptions of the damage."""
    stops: tuple[Logged, ...]
    """The stops with which a lockstep run took back its last commands, which are in none of the others."""
    is_own: bool
    """Whether a lockstep run wrote the log, not a logger: then its events have the messages' timestamps."""

    @property
    def last_us(self) -> int:
        """The newest timestamp, microseconds, 0 in an empty log."""
        return max((message.utime for message in self.order), default=0)


def read_contents(
    recording: Recording, graph: Graph, about: About | None, recorded: Graph | None = None, *, is_live: bool
) -> Contents:
    """Return the undamaged messages of a log on the channels of ``graph``, and of ``recorded`` if it is given.

    ``is_live``: whether it is the log of a live run, whose events have the run's clock, not the messages' timestamps.

    Raises
    ------
    UserError
        The log holds several runs.
    """
    graphs = [graph] if recorded is None else [recorded, graph]
    channels = {channel.name: channel for one in graphs for channel in one.channels.values()}
    heads = [head for head in recording.heads() if not head.channel.startswith(RESERVED)]
    own = [head for head in heads if head.channel in channels]
    is_own = not is_live and 2 * sum(head.logged_us == head.utime for head in own) > len(own)
    other_types = _other_types(own, channels)
    known = {*channels, *about.channels} if about is not None else {head.channel for head in heads}
    messages: dict[str, list[Logged]] = {name: [] for name in channels}
    order: list[Logged] = []
    lost = _lost_bytes(recording)
    for head in heads:
        if head.channel in other_types or (head.channel not in known and not is_own):
            continue
        if _is_damaged(head, channels, known, is_own=is_own):
            lost.append(f"event {head.place} of channel {head.channel!a} is damaged")
        elif head.channel in channels and not _is_repeated(head, messages[head.channel]):
            at_us = head.logged_us if is_live else head.utime
            message = Logged(head.channel, head.place, head.utime, head.seq, head.n_bytes, at_us)
            messages[head.channel].append(message)
            order.append(message)
    if not is_own and not is_live:
        _refuse_several_runs(recording, messages, _stamped(graph))
    stops = [] if is_live else _taken_stops(graphs, messages, order)
    if len(lost) > _MAX_TOLD:
        lost = [*lost[:_MAX_TOLD], f"and {len(lost) - _MAX_TOLD} more"]
    return Contents(
        {name: tuple(found) for name, found in messages.items()},
        tuple(order),
        other_types,
        tuple(lost),
        tuple(stops),
        is_own,
    )


def _taken_stops(graphs: Sequence[Graph], messages: Mapping[str, list[Logged]], order: list[Logged]) -> list[Logged]:
    """Remove the commands that take back the ones before, and return them: no stage publishes two of one stamp."""
    names = dict.fromkeys(channel.name for graph in graphs for channel in graph.commands)
    found = (messages[name] for name in names)
    stops = [sent.pop() for sent in found if len(sent) > 1 and sent[-1].utime == sent[-2].utime]
    for stop in stops:
        order.remove(stop)
    return stops


def _lost_bytes(recording: Recording) -> list[str]:
    """Return descriptions of bytes that are not events."""
    return [*map(str, recording.damaged), *([str(recording.truncated)] if recording.truncated else [])]


def _other_types(heads: Sequence[Head], channels: Mapping[str, Channel]) -> frozenset[str]:
    """Return the channels without any message of the type in the graph."""
    right: dict[str, bool] = defaultdict(bool)
    for head in heads:
        right[head.channel] |= head.fingerprint == codec_of(channels[head.channel].message.lcm_class).fingerprint
    return frozenset(name for name, is_right in right.items() if not is_right)


def _is_damaged(head: Head, channels: Mapping[str, Channel], known: Collection[str], *, is_own: bool) -> bool:
    if head.channel not in known or (is_own and head.logged_us != head.utime):
        return True
    channel = channels.get(head.channel)
    return channel is not None and head.fingerprint != codec_of(channel.message.lcm_class).fingerprint


def _is_repeated(head: Head, before: Sequence[Logged]) -> bool:
    """Whether a message repeats the previous one: the tap repeats messages that were published once."""
    return bool(before) and (before[-1].utime, before[-1].seq) == (head.utime, head.seq)


def _stamped(graph: Graph) -> set[str]:
    """Return the channels whose messages have their own timestamps."""
    return {node.outputs[port.name].name for node in graph.nodes for port in node.output_ports if port.stamped}


def _refuse_several_runs(
    recording: Recording, messages: Mapping[str, Sequence[Logged]], stamped: Collection[str]
) -> None:
    for name, found in messages.items():
        if name in stamped:
            continue
        for before, after in itertools.pairwise(found):
            if after.utime < before.utime:
                what = (
                    f"{recording.path} holds several runs: '{name}' jumps back from {before.utime / 1e6:.2f} s "
                    f"to {after.utime / 1e6:.2f} s"
                )
                raise UserError.of(what, "record one run per log")
