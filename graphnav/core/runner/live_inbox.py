"""Messages that wait for a stage in a live run: sets of its plain inputs, sampled and gathered inputs, their ages."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Mapping
from typing import Any

from graphnav.core.graph import Node
from graphnav.core.messages import Message
from graphnav.core.runner.firing import Taken, Used
from graphnav.core.runner.join import MAX_UNMATCHED, Held, Join, MatchedSet
from graphnav.core.stage import Latest, Port, Since


class LiveInbox:
    """Holds the messages of a stage, and tells which set of its plain inputs it may fire with.

    ``fault_of``: returns the fault in the stamps of the input that feeds a channel, by reference; empty if none.
    """

    MAX_GATHERED = 4096
    """Maximum number of messages of a `Since` input; a sender of 1 kHz fills it in 4 s."""

    def __init__(
        self, node: Node, queues: Mapping[str, int | None], fault_of: Callable[[str, float], str] = lambda *_: ""
    ) -> None:
        self._node = node
        self._plain = [i.port.name for i in node.inputs if i.port.is_plain and i.channel is not None]
        sizes = [queues[f"{node.name}.{port}"] for port in self._plain if f"{node.name}.{port}" in queues]
        bound = MAX_UNMATCHED if not sizes else None if None in sizes else max(size or 0 for size in sizes)
        self.join = Join(self._plain, max_unmatched=bound, in_order=bool(sizes))
        self.birth_s = self.origin_s = math.nan
        """Times from which the age and the latency of the stage's newest outputs are measured, monotonic seconds; they
        differ for a stage with a timer, whose every firing is a new decision; NaN if there was no new input."""
        self.is_clocked = node.every_ms is not None
        """Whether the stage also has a timer; then its outputs are stamped by the run's own clock."""
        self._is_withheld = False
        self._fault_of = fault_of
        self._held: MatchedSet | None = None
        self._newest: dict[str, tuple[Message, float, Used]] = {}
        self._latest = [i.port.name for i in node.inputs if i.port.latest]
        self._gathered: dict[str, deque[tuple[Message, Used]]] = {
            i.port.name: deque(maxlen=LiveInbox.MAX_GATHERED) for i in node.inputs if i.port.since
        }
        self._reached: dict[str, int] = {}
        self._channel_of = {i.port.name: i.channel.ref for i in node.inputs if i.channel is not None}
        self._needs = {i.port.name for i in node.inputs if i.port.is_plain and not i.port.optional}

    @property
    def dropped(self) -> int:
        """Number of overtaken messages."""
        return self.join.overtaken.total()

    def adopt(self, before: LiveInbox) -> None:
        """Take what waits for the stage before on inputs that read the same channel alike, and what was overtaken.

        The newest complete set stays only where all plain inputs do.
        """
        same = self._node.same_inputs(before._node)
        self.join.adopt(before.join, same.intersection(self._plain))
        self._newest = {port: newest for port, newest in before._newest.items() if port in same}
        self._gathered |= {port: gathered for port, gathered in before._gathered.items() if port in same}
        self._reached = {port: utime for port, utime in before._reached.items() if port in same}
        self._is_withheld = before._is_withheld
        if same.issuperset(self._plain) and self._plain == before._plain:
            self._held = before._held

    def put(self, port: Port, utime: int, number: int, message: Message, birth_s: float, now_s: float) -> None:
        """Add a message; ``birth_s``: the time from which its age counts."""
        name = port.name
        if port.since:
            self._gathered[name].append((message, Used(name, number, utime)))
            self._reached[name] = max(utime, self._reached.get(name, utime))
        elif port.latest:
            self._newest[name] = (message, birth_s, Used(name, number, utime))
        elif not self._is_withheld:
            self.join.put(name, utime, Held(message, birth_s, now_s, number))

    def restart(self) -> None:
        """Drop everything whose stamps have become meaningless, also the newest complete set."""
        self.join.clear()
        self._held = None
        self._reached.clear()
        for gathered in self._gathered.values():
            gathered.clear()

    def withhold(self, *, is_withheld: bool) -> None:
        """Drop what its plain inputs hold, and what they get until the opposite is asked."""
        if is_withheld and not self._is_withheld:
            self.restart()
        self._is_withheld = is_withheld

    def ready(self, now_s: float, patience_s: Callable[[], float]) -> MatchedSet | None:
        """Return the set that would fire now, None if there is none or its `Since` inputs are not that far.

        ``patience_s``: returns how long a set waits for them; called only if they are behind.
        """
        return self.join.newest_allowed(lambda one: self._waits_until_s(one, patience_s) <= now_s)

    def wakes_at_s(self, patience_s: Callable[[], float]) -> float:
        """Return the time at which the first waiting set has waited long enough, infinity if none waits."""
        waiting = map(self.join.peek, self.join.complete())
        return min((self._waits_until_s(matched, patience_s) for matched in waiting), default=math.inf)

    def take_set(self, matched: MatchedSet, now_s: float) -> Taken:
        """Return what the stage steps with: a set that is `ready`."""
        self._held = self.join.take(matched.utime)
        self.origin_s = self._held.birth_s
        self.birth_s = now_s if self.is_clocked else self._held.birth_s
        return self._take(now_s)

    def take_timer(self, now_s: float, patience_s: Callable[[], float]) -> Taken | None:
        """Return what the stage steps with on its timer: the newest complete set, or none if all of it is optional.

        None if it does not step.
        """
        if (matched := self.ready(now_s, patience_s)) is not None:
            return self.take_set(matched, now_s)
        if self._held is None and self._needs:
            return None
        return self.take_no_set(now_s, birth_s=now_s, origin_s=math.nan)

    def take_no_set(self, now_s: float, birth_s: float, origin_s: float) -> Taken:
        """Return what the stage steps with where no new set fires it; ``birth_s``, ``origin_s``: of its outputs."""
        self.birth_s, self.origin_s = birth_s, origin_s
        return self._take(now_s)

    def _waits_until_s(self, matched: MatchedSet, patience_s: Callable[[], float]) -> float:
        """Return the time until which a complete set waits for `Since` inputs, minus infinity if it does not wait."""
        behind = [p for p in self._gathered if p in self._channel_of and self._reached.get(p, 0) < matched.utime]
        return matched.ready_s + patience_s() if behind else -math.inf

    def _take(self, now_s: float) -> Taken:
        held, held_s = (self._held.held, self._held.birth_s) if self._held is not None else ({}, 0.0)
        inputs: dict[str, Any] = {port: held[port].message if port in held else None for port in self._plain}
        used = [Used(port, one.number, self._held.utime) for port, one in held.items() if self._held is not None]
        for port in self._latest:
            inputs[port] = self._sample(port, now_s)
            if port in self._channel_of:
                newest = self._newest[port][2] if port in self._newest else Used(port, -1, 0)
                used.append(newest._replace(age_s=inputs[port].age_s, fault=inputs[port].fault))
        for port, gathered in self._gathered.items():
            inputs[port] = Since(tuple((one.utime, message) for message, one in gathered))
            used += [one for _, one in gathered]
            gathered.clear()
        return Taken(inputs, now_s - held_s if held else math.inf, used)

    def _sample(self, port: str, now_s: float) -> Latest[Any]:
        if port not in self._channel_of:
            return Latest(is_connected=False)
        fault = self._fault_of(self._channel_of[port], now_s)
        if port not in self._newest:
            return Latest(fault=fault)
        message, birth_s, _ = self._newest[port]
        return Latest(message, now_s - birth_s, fault)
