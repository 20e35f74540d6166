"""Tell what holds the robot: inputs that contradict its motion at once, other stops of a guard when they last."""

from __future__ import annotations

import shlex
from collections import Counter
from collections.abc import Iterator

from graphnav import Graph, GuardState, UserError
from graphnav.core.bus import Bus
from graphnav.core.graph import Node
from graphnav.core.lcm_url import lcm_url
from graphnav.live.live_schedule import LiveSchedule

_STANDS_S = 2.0
"""A stop that lasts longer is told, and its end when it has been over for as long: neither is told of a flicker."""
_TURNS_S = 10.0
"""The same for a robot that may turn, but not go forward: it turns away from obstacles within seconds."""
_MAX_NAMED = 3
_BY_HAND = (
    ("stop", "--stop-channel", "STOP", "press r to arm it"),
    ("override", "--channel", "TELEOP", "drive it by hand"),
)
"""A guard's inputs from an operator, and what `graphnav teleop` does with them."""
_RETRIES, _LATCHED = "the robot retries, slowly", "the robot stands until the guard is armed"


class GuardHolds:
    """Yields what begins and ends to hold the robot, by the newest states of the guards; ``url``: of the run.

    `look` is called at every turn of the schedule, so that a retry, which may be short, is not missed.
    """

    def __init__(self, schedule: LiveSchedule, url: str) -> None:
        self._schedule, self._url = schedule, url
        self._holds: dict[str, Hold] = {}
        self._seen: dict[str, GuardState] = {}

    def look(self, now_s: float) -> Iterator[str]:
        """Yield what is new since the last call; ``now_s``: monotonic."""
        for stage, state in self._schedule.guard_states.items():
            if self._seen.get(stage) is not state:
                self._seen[stage] = state
                if stage not in self._holds:
                    self._holds[stage] = Hold(self._schedule.graph, stage, self._url)
                yield from self._holds[stage].see(state, now_s)


class Hold:
    """The time in which one guard holds the robot, from the first cause until there was none for two seconds.

    A cause is told once. Retries and latches, which may alternate, are told at first, and again when their number has
    doubled. An override ends nothing: the operator sees what holds the robot when he lets go.
    """

    def __init__(self, graph: Graph, stage: str, url: str) -> None:
        self._node = next(node for node in graph.nodes if node.name == stage)
        self._inputs = {i.port.name for i in self._node.inputs if i.channel and i.channel.ref in graph.inputs}
        self._remedy = _remedy(graph, self._node, url)
        self._clear()

    def _clear(self) -> None:
        self._begin_s = self._untold_s = self._free_s = -1.0
        self._told: dict[tuple[str, str], None] = {}
        self._phase = ""
        self._counts = Counter[str]()

    def see(self, state: GuardState, now_s: float) -> Iterator[str]:
        """Yield the lines on a new state."""
        if state.overridden:
            return
        if state.may_advance and not state.is_retrying:
            yield from self._end(now_s)
            return
        if self._begin_s < 0.0:
            self._begin_s = now_s
        if self._untold_s < 0.0:
            self._untold_s = now_s
        self._free_s = -1.0
        phase = _RETRIES if state.is_retrying else _LATCHED if state.stopped else ""
        if phase != self._phase:
            self._phase = phase
            self._counts[phase] += 1
            count = self._counts[phase]
            if phase and not count & (count - 1):
                again = f" ({count} times so far)" if count > 1 else ""
                yield self._line(phase + again, state) + (self._remedy if phase == _LATCHED else "")
        yield from self._causes(state, now_s)

    def _causes(self, state: GuardState, now_s: float) -> Iterator[str]:
        """Yield a line on the causes, if none that was told holds the robot any more, or one contradicts its motion."""
        causes = list(zip(state.causes, state.ports, strict=True))
        if any(cause in self._told for cause in causes):
            self._untold_s = now_s
        wait_s = _TURNS_S if state.may_move else _STANDS_S
        is_contrary = any(state.is_contradiction(cause[0]) and cause not in self._told for cause in causes)
        if is_contrary or now_s - self._untold_s >= wait_s:
            yield self._line("the robot may turn, but not go forward" if state.may_move else "the robot stands", state)

    def _line(self, what: str, state: GuardState) -> str:
        """Return a line with the causes, those of what comes from other programs first; they are told by it."""
        causes = list(zip(state.causes, state.ports, state.described(), strict=True))
        causes.sort(key=lambda cause: (not state.is_contradiction(cause[0]), cause[1] not in self._inputs))
        self._told |= {(name, port): None for name, port, _ in causes}
        named = "; ".join(text for _, _, text in causes[:_MAX_NAMED])
        more = f"; {len(causes) - _MAX_NAMED} more" if len(causes) > _MAX_NAMED else ""
        return f"{self._node.name}: {what}: {named}{more}"

    def _end(self, now_s: float) -> Iterator[str]:
        if self._begin_s < 0.0:
            return
        if self._free_s < 0.0:
            self._free_s, self._untold_s = now_s, -1.0
        if now_s - self._free_s >= _STANDS_S:
            if self._told:
                names = ", ".join(dict.fromkeys(name for name, _ in self._told))
                held_s = self._free_s - self._begin_s
                yield f"{self._node.name}: the robot may move again, after {held_s:.1f} s: {names}"
            self._clear()


def _remedy(graph: Graph, node: Node, url: str) -> str:
    """Return what an operator has to do where a guard waits for him, by the channels that the graph wires."""
    sources = {i.port.name: graph.inputs.get(i.channel.ref) for i in node.inputs if i.channel is not None}
    words, deeds = ["graphnav", "teleop"], []
    for port, option, default, deed in _BY_HAND:
        source = sources.get(port)
        if source is not None and source.is_channel:
            deeds.append(deed)
            words += [option, source.name] * (source.name != default)
    if not deeds:
        return "\n  look, end the run, and start it again: its graph has no input by which an operator helps"
    try:
        is_default = Bus.same_group(url, lcm_url())
    except UserError:  # of LCM_DEFAULT_URL, where the run has a URL of its own
        is_default = False
    if not is_default:
        words += ["--url", url]
    return f"\n  look, then {' or '.join(deeds)} in: {shlex.join(words)}"
