"""Read the firings of a live run from its log, and the messages of each step."""

from __future__ import annotations

import math
from collections import Counter, deque
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from typing import NamedTuple

from graphnav import Recording, UserError
from graphnav.core.codec import DecodeError, decode
from graphnav.core.graph import Channel, Node
from graphnav.core.messages import Fired
from graphnav.core.runner import Used
from graphnav.replay.log.contents import Contents, Logged
from graphnav.replay.plan import Plan


class Firing(NamedTuple):
    """A firing: its time by the run's clock, the timestamp of the step, and the messages of the step."""

    at_us: int
    stage: str
    utime: int
    age_s: float
    used: tuple[Used, ...]


@dataclass(frozen=True)
class LoggedFirings:
    """The firings of a run, in log order, and the messages that they read."""

    firings: tuple[Firing, ...]
    """All firings, including those of stages that do not step."""
    messages: tuple[Logged, ...]
    """Recorded messages that are not published by a stepping stage, in order of publication."""
    played: Mapping[tuple[str, int, int], Logged]
    """The messages that firings read from the log, by channel, number and timestamp."""
    awaited: Counter[tuple[str, str, int]]
    """How often firings read a message of another stepping stage, by the reading stage, port and timestamp."""
    is_cut: bool
    """Whether damage of the log removed messages that later firings read."""
    added: frozenset[str]
    """Stages that the run did not have."""
    new_ports: frozenset[tuple[str, str]]
    """Inputs of other stages that were not read in the run, by stage and port."""
    channels: Mapping[str, Mapping[str, str]]
    """The channels read by stages that do not step, by stage and port."""


def read_firings(
    plan: Plan, contents: Contents, recording: Recording, wires: Mapping[str, Mapping[str, str]]
) -> LoggedFirings:
    """Return the firings of a log up to the first one whose messages are missing because of damage.

    ``wires``: the channel of each port in that run, by stage and port.

    Raises
    ------
    UserError
        The log holds no firings, or messages of steps are missing for another reason than damage.
    """
    added = plan.stepped_names - wires.keys()
    new_ports = frozenset(new for new in new_inputs(plan, wires) if new[0] not in added)
    reader, changes = _Reader(plan, contents, new_ports), deque(plan.changes)
    firings: list[Firing] = []
    n_missing: Counter[str] = Counter()
    n_complete: float = math.inf
    for firing in _decoded(recording):
        while changes and changes[0].at_us <= firing.at_us:
            reader.change(changes.popleft().node)
        if missing := reader.take(firing) if firing.stage in plan.stepped_names else []:
            n_missing.update(missing)
            n_complete = min(n_complete, len(firings))
        firings.append(firing)
    if not firings:
        what = f"{recording.path} does not hold the firings of the stages: no '{Fired.CHANNEL}'"
        raise UserError.of(what, "record the live run with this version of graphnav, in its own log")
    if n_missing and not (contents.lost and n_complete):
        lines = [f"{name}: {count} of {reader.read[name]}" for name, count in n_missing.items()]
        what = "\n  ".join([f"{recording.path} is missing messages that its stages stepped with:", *lines])
        hint = "record what a replay needs: --set run.record=replayable; or play what these stages publish with --play"
        raise UserError.of(what, hint)
    kept = firings if math.isinf(n_complete) else firings[: int(n_complete)]
    held = {channel.name for channel in (*plan.played, *plan.copied)}
    return LoggedFirings(
        firings=tuple(kept),
        messages=tuple(sorted((one for one in contents.order if one.channel in held), key=lambda one: one.at_us)),
        played=reader.played,
        awaited=reader.awaited,
        is_cut=len(kept) < len(firings),
        added=added,
        new_ports=new_ports,
        channels={
            node.name: {i.port.name: i.channel.name for i in node.inputs if i.channel is not None}
            for node in plan.graph.nodes
            if node.name not in plan.stepped_names
        },
    )


def _decoded(recording: Recording) -> Iterator[Firing]:
    for index in range(recording.count(Fired.CHANNEL)):
        event = recording.event(Fired.CHANNEL, index)
        try:
            utime, _, fired = decode(Fired, event.data)
        except DecodeError:
            continue
        numbers, stamps, ages = fired.numbers.tolist(), fired.stamps_us.tolist(), fired.ages_s.tolist()
        used = map(Used, fired.ports, numbers, stamps, ages, fired.faults)
        yield Firing(fired.fired_us, fired.stage, utime, fired.age_s, tuple(used))


class _Reader:
    """Finds the messages of firings in the log."""

    def __init__(self, plan: Plan, contents: Contents, new_ports: Collection[tuple[str, str]]) -> None:
        self.played: dict[tuple[str, int, int], Logged] = {}
        self.awaited: Counter[tuple[str, str, int]] = Counter()
        self.read: Counter[str] = Counter()
        """The number of messages read of each played channel."""
        self._seen: set[tuple[str, int, int]] = set()
        self._is_played = {channel.ref for channel in plan.played}
        self._new_ports = new_ports
        self._ports: dict[str, dict[str, tuple[Channel, bool]]] = {}
        for node in plan.stepped_at_first.nodes:
            self.change(node)
        self._by_place = {name: {one.place: one for one in found} for name, found in contents.messages.items()}
        self._by_stamp = {name: {one.utime: one for one in found} for name, found in contents.messages.items()}

    def change(self, node: Node) -> None:
        """Read from now on what this stage reads."""
        self._ports[node.name] = {
            i.port.name: (i.channel, i.channel.ref in self._is_played)
            for i in node.inputs
            if i.channel is not None and (node.name, i.port.name) not in self._new_ports
        }

    def take(self, firing: Firing) -> list[str]:
        """Record the messages that a firing reads; return the channels of missing ones."""
        missing = []
        for used in firing.used:
            channel, is_played = self._ports[firing.stage].get(used.port, (None, False))
            if channel is None or used.number < 0:
                continue
            if not is_played:
                self.awaited[firing.stage, used.port, used.utime] += 1
                continue
            key = channel.name, used.number, used.utime
            if key in self._seen:
                continue
            self._seen.add(key)
            self.read[channel.name] += 1
            found = self._find(channel, used)
            if found is None:
                missing.append(channel.name)
            else:
                self.played[key] = found
        return missing

    def _find(self, channel: Channel, used: Used) -> Logged | None:
        """Return a message by its number; by its timestamp if messages before it are missing in the log."""
        found = self._by_place[channel.name].get(used.number)
        if found is not None and (found.utime == used.utime or channel.message.many_writers):
            return found
        return self._by_stamp[channel.name].get(used.utime)


def new_inputs(plan: Plan, wires: Mapping[str, Mapping[str, str]]) -> Iterator[tuple[str, str]]:
    """Yield stage and port of inputs of stepping stages that the run did not have, or had wired differently.

    ``wires``: the channel of each port in that run, by stage and port.
    """
    for node in plan.stepped_at_first.nodes:
        for i in node.inputs:
            if i.channel is not None and wires.get(node.name, {}).get(i.port.name) != i.channel.ref:
                yield node.name, i.port.name
