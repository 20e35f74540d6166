"""A stage in a live run: fires on the newest complete set of its plain inputs, and on its timer."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from graphnav.graph import Node
from graphnav.live.firing import Used
from graphnav.live.join import MAX_UNMATCHED, Held, Join, MatchedSet
from graphnav.messages import Message
from graphnav.runner.unit import Publish, Unit
from graphnav.stage import Latest, Since, Stage

MAX_GATHERED = 4096
"""Maximum number of messages of a `Since` input; a sender of 1 kHz fills it in 4 s."""


class LiveUnit(Unit):
    """Holds the messages that arrived for a stage and decides when it may fire.

    ``fault_of``: returns the fault in the stamps of the input that feeds a channel, by reference; empty if none.
    """

    def __init__(
        self,
        node: Node,
        stage: Stage,
        publish: Publish,
        queues: Mapping[str, int | None],
        fault_of: Callable[[str, float], str],
    ) -> None:
        super().__init__(node, stage, publish)
        sizes = [queues[f"{node.name}.{port}"] for port in self._plain if f"{node.name}.{port}" in queues]
        bound = MAX_UNMATCHED if not sizes else None if None in sizes else max(size or 0 for size in sizes)
        self.join = Join(self._plain, max_unmatched=bound, in_order=bool(sizes))
        self.birth_s = self.origin_s = math.nan
        """Times from which the age and the latency of its newest outputs are measured, monotonic seconds; they differ
        for a stage with a timer, whose every firing is a new decision; NaN if there was no new input."""
        self._is_withheld = False
        self._fault_of = fault_of
        self._held: MatchedSet | None = None
        self.before_step: Callable[[LiveUnit, int, float, Sequence[Used]], None] | None = None
        """If set, called before each step with the stamp, the age of the plain inputs and the messages."""
        self._newest: dict[str, tuple[Message, float, Used]] = {}
        self._gathered: dict[str, deque[tuple[Message, Used]]] = {p: deque(maxlen=MAX_GATHERED) for p in self._since}
        self._reached: dict[str, int] = {}
        self._channel_of = {i.port.name: i.channel.ref for i in node.inputs if i.channel is not None}
        self._needs = {i.port.name for i in node.inputs if i.port.is_plain and not i.port.optional}

    @property
    def is_clocked(self) -> bool:
        """Whether it also has a timer; then its outputs are stamped by the run's own clock."""
        return self.node.every_ms is not None

    @property
    def dropped(self) -> int:
        """Number of overtaken messages."""
        return self.join.overtaken.total()

    def deliver(self, port: str, utime: int, message: Message, birth_s: float, now_s: float, number: int) -> None:
        """Add a message; ``number``: its index in the channel, from 0."""
        if port in self._gathered:
            self._gathered[port].append((message, Used(port, number, utime)))
            self._reached[port] = max(utime, self._reached.get(port, utime))
        elif port in self._latest:
            self._newest[port] = (message, birth_s, Used(port, number, utime))
        elif not self._is_withheld:
            self.join.put(port, utime, Held(message, birth_s, now_s, number))

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

    def ready(self, now_s: float) -> MatchedSet | None:
        """Return the set that would fire now, None if there is none or its `Since` inputs are not that far."""
        return self.join.newest_allowed(lambda one: self.waits_until_s(one) <= now_s)

    def waits_until_s(self, matched: MatchedSet) -> float:
        """Return the time until which a complete set waits for `Since` inputs, minus infinity if it does not wait."""
        behind = [p for p in self._since if p in self._channel_of and self._reached.get(p, 0) < matched.utime]
        return matched.ready_s + self.patience_s() if behind else -math.inf

    def wakes_at_s(self) -> float:
        """Return the time at which the first waiting set has waited long enough, infinity if none waits."""
        return min((self.waits_until_s(self.join.peek(utime)) for utime in self.join.complete()), default=math.inf)

    def fire_set(self, matched: MatchedSet, utime: int, now_s: float) -> str | None:
        """Step with a set returned by `ready`; ``utime``: the stamp of the outputs."""
        self._held = self.join.take(matched.utime)
        self.origin_s = self._held.birth_s
        self.birth_s = now_s if self.is_clocked else self._held.birth_s
        return self._fire(utime, now_s)

    def fire_timer(self, utime: int, now_s: float) -> str | None:
        """Step with the newest complete set, or without one if every plain input is optional."""
        if (matched := self.ready(now_s)) is not None:
            return self.fire_set(matched, utime, now_s)
        if self._held is None and self._needs:
            return None
        return self.fire_source(utime, now_s, origin_s=math.nan)

    def fire_source(self, utime: int, now_s: float, origin_s: float | None = None) -> str | None:
        """Step without a new set."""
        self.birth_s = now_s
        self.origin_s = now_s if origin_s is None else origin_s
        return self._fire(utime, now_s)

    def needs(self, port: str) -> bool:
        """Whether the stage never fires without messages on this input."""
        return port in self._plain or port in self._since

    def is_plain(self, port: str) -> bool:
        """Whether messages on this input fire the stage."""
        return port in self._plain

    def _fire(self, utime: int, now_s: float) -> str | None:
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
        age_s = now_s - held_s if held else math.inf
        if self.before_step is not None:
            self.before_step(self, utime, age_s, used)
        return self.step(utime, inputs, age_s)

    def _sample(self, port: str, now_s: float) -> Latest[Any]:
        if port not in self._channel_of:
            return Latest(is_connected=False)
        fault = self._fault_of(self._channel_of[port], now_s)
        if port not in self._newest:
            return Latest(fault=fault)
        message, birth_s, _ = self._newest[port]
        return Latest(message, now_s - birth_s, fault)
