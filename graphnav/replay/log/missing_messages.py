"""Find messages of a channel that a replay needs but the log does not hold."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from graphnav import Graph, Recording
from graphnav.core.graph import Channel
from graphnav.core.stage import Port
from graphnav.replay.log.contents import Contents, Logged
from graphnav.replay.plan import Plan


class MissingMessages(NamedTuple):
    """Missing messages of a channel: their number, and the timestamps between which they were published.

    ``n_messages``: 0 if unknown. ``after_us``: minus infinity if the first message is missing.
    """

    n_messages: int
    after_us: float
    before_us: float


def missing_messages(channel: Channel, plan: Plan, contents: Contents) -> list[MissingMessages]:
    """Return the missing messages of a played channel."""
    messages = contents.messages[channel.name]
    port = _port(channel, plan.graph)
    if not messages:
        is_missing = (port is not None and not port.optional) or _has_effects(channel, plan, contents)
        return [MissingMessages(0, -math.inf, math.inf)] if is_missing else []
    missing = numbered_gaps(messages)
    is_regular = port is not None and not (port.optional or port.stamped) and plan.graph.node(channel.stage).is_source
    return missing + (
        _regular_rest(channel, plan, contents) if is_regular else _large_rest(channel, port, plan, contents)
    )


def _port(channel: Channel, graph: Graph) -> Port | None:
    """Return the output port that writes a channel, None for an input."""
    if channel.ref in graph.inputs:
        return None
    writers = (node for node in graph.nodes if node.name == channel.stage)
    return next(port for node in writers for port in node.output_ports if port.name == channel.port)


def _has_effects(channel: Channel, plan: Plan, contents: Contents) -> bool:
    """Whether a stage that is fired by the channel has published, so that the channel was not silent."""
    return any(
        contents.messages[written.name]
        for node in plan.stepped.nodes
        if any(i.channel == channel and i.port.is_plain for i in node.inputs)
        for written in node.outputs.values()
    )


def numbered_gaps(messages: Sequence[Logged]) -> list[MissingMessages]:
    """Return the gaps in the sequence numbers; a number that fits neither of two matching neighbours is damaged."""
    missing: list[MissingMessages] = []
    last_seq, last_us = -1, -math.inf
    for place, message in enumerate(messages):
        following = messages[place + 1].seq if place + 1 < len(messages) else None
        seq = last_seq + 1 if following == last_seq + 2 else message.seq
        if seq > last_seq + 1:
            missing.append(MissingMessages(seq - last_seq - 1, last_us, message.utime))
        last_seq, last_us = max(seq, last_seq), message.utime
    return missing


def _regular_rest(channel: Channel, plan: Plan, contents: Contents) -> list[MissingMessages]:
    """Return the missing end of a channel on which a source publishes at every firing, from its other channels.

    The last tick of the log is left out: it may be incomplete if the run was killed.
    """
    node = plan.graph.node(channel.stage)
    last_us = contents.messages[channel.name][-1].utime
    later: dict[bool, set[int]] = {True: set(), False: set()}
    for port in node.output_ports:
        messages = () if port.stamped else contents.messages[node.outputs[port.name].name]
        later[port.optional] |= {one.utime for one in messages if last_us < one.utime < contents.last_us}
    if not (later[True] or later[False]):
        return []
    return [MissingMessages(len(later[False]) if later[False] >= later[True] else 0, last_us, math.inf)]


def _large_rest(channel: Channel, port: Port | None, plan: Plan, contents: Contents) -> list[MissingMessages]:
    """Return the missing end of a channel of which the log keeps only the first message, because it is large.

    A source may publish a large message only once, such as a map, for stages that sample it.
    """
    messages = contents.messages[channel.name]
    if not is_first_only(messages, contents):
        return []
    is_sampled = not any(i.channel == channel and i.port.is_plain for n in plan.stepped.nodes for i in n.inputs)
    is_once = is_sampled and (port is None or port.optional)
    return [] if is_once else [MissingMessages(0, messages[0].utime, math.inf)]


def is_first_only(messages: Sequence[Logged], contents: Contents) -> bool:
    """Whether a log may hold only the first message of a channel because it is large."""
    return len(messages) == 1 and messages[0].n_bytes >= Recording.SMALL_BYTES and messages[0].utime < contents.last_us
