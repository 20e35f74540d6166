"""The observations and the actions of an agent, by the names of channels: resolved, or refused with the reason."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from graphnav import Graph, Latest, Twist, UserError, did_you_mean, numeric_layout
from graphnav.core.graph import Channel, Node
from graphnav.core.messages import ZERO_MEANS
from graphnav.core.stage import Port

OF_THE_GRID = (*ZERO_MEANS, "interval_us")
"""Fields that describe the array beside them, the same in every message: no part of observations and actions."""


@dataclass(frozen=True)
class Observed:
    """A channel that the agent observes, and how it reads it.

    ``port``: the input of the agent. ``fields``: those that are observed. ``sampled``: whether it is the newest message
    (`Latest`) and does not fire the agent.
    """

    port: str
    channel: Channel
    fields: tuple[str, ...]
    sampled: bool

    @property
    def kind(self) -> object:
        """The annotation of the agent's input."""
        return Latest[self.channel.message] if self.sampled else self.channel.message  # type: ignore[name-defined]

    def key(self, field: str) -> str:
        """Return the name of a field's array among those of all channels."""
        return self.port if len(numeric_of(self.channel)) == 1 else f"{self.port}_{field}"


@dataclass(frozen=True)
class Interface:
    """The channels that an agent observes, and the one that it writes in place of a stage."""

    observed: tuple[Observed, ...]
    acts: Channel

    @property
    def sees_truth(self) -> bool:
        """Whether it observes true data."""
        return any(one.channel.message.is_truth for one in self.observed)


def numeric_of(channel: Channel) -> tuple[str, ...]:
    """Return the fields of a channel's messages that observations and actions have."""
    return tuple(name for name in numeric_layout(channel.message) if name not in OF_THE_GRID)


def interface_of(graph: Graph, observe: Sequence[str] | None, act: str | None, *, truth: bool) -> Interface:
    """Return the interface of an agent in a graph; None: the image, and what commands the robot.

    Raises
    ------
    UserError
        The graph is not a closed loop in simulated time, or has no such channel, or an agent may not have it.
    """
    if graph.is_live:
        raise UserError.of(f"{graph.path.stem} has live inputs, but a learner needs a simulated world", _CLOSED)
    acts = _default_act(graph) if act is None else _acts(graph, act)
    made = made_from(graph, acts.stage)
    words = [_default_image(graph).ref] if observe is None else observe
    found: dict[str, tuple[Channel, list[str]]] = {}
    for word in words:
        channel, field = _observed(graph, word, truth=truth)
        fields = found.setdefault(channel.ref, (channel, []))[1]
        fields += [name for name in ([field] if field else numeric_of(channel)) if name not in fields]
    if not found:
        raise UserError.of("observe names no channel", "write observe=['robot.image']")
    channels = [channel for channel, _ in found.values()]
    if acts.ref in found:
        raise UserError.of(f"observe: the agent itself writes '{acts.ref}'", "leave it out")
    ports = _ports(channels)
    observed = tuple(
        Observed(ports[ref], channel, tuple(fields), channel.stage in made or _port_of(graph, channel).stamped)
        for ref, (channel, fields) in found.items()
    )
    if all(one.sampled for one in observed):
        what = f"observe: all of {', '.join(found)} follows from the action, so nothing tells when to act"
        raise UserError.of(what, "observe also what comes before it, such as the image")
    return Interface(observed, acts)


_CLOSED = "use a graph whose world samples a command, such as corridor_ccw"


def made_from(graph: Graph, stage: str) -> frozenset[str]:
    """Return the stages that a stage fires, directly or through others."""
    found = {stage}
    for node in graph.order:
        if found.intersection(node.writers):
            found.add(node.name)
    return frozenset(found - {stage})


def _ports(channels: Sequence[Channel]) -> Mapping[str, str]:
    """Return the name of each channel's input by its reference: that of the port, with the stage if several have it."""
    names = [channel.port for channel in channels]
    return {
        channel.ref: channel.port if names.count(channel.port) == 1 else f"{channel.stage}_{channel.port}"
        for channel in channels
    }


def _port_of(graph: Graph, channel: Channel) -> Port:
    return next(port for port in graph.node(channel.stage).output_ports if port.name == channel.port)


def _observed(graph: Graph, word: str, *, truth: bool) -> tuple[Channel, str]:
    """Return the channel that a word names, ``stage.port``, a channel or a stage, and the field that it adds, or ""."""
    channel, field = _named(graph, word, "observe"), ""
    if channel is None:
        before, _, field = word.rpartition(".")
        found = _matching(graph, before)
        channel = found[0] if len(found) == 1 else None
    if channel is None:
        raise _unknown(graph, word, "observe")
    if graph.node(channel.stage).stage_class.role == "score":
        what = f"observe: '{channel.ref}' is of a score, which only measures: no agent may see it"
        raise UserError.of(what, "use its metrics in reward=")
    if channel.message.is_truth and not truth:
        what = f"observe: '{channel.ref}' is true data, which no robot has: a policy that needs it cannot drive one"
        raise UserError.of(what, "write truth=True for a teacher or a critic that may see it")
    fields = numeric_of(channel)
    if not fields:
        raise UserError.of(f"observe: {channel.message.__name__} of '{channel.ref}' holds no numbers", "leave it out")
    if field and field not in fields:
        hint = did_you_mean(field, fields) or f"fields are {', '.join(fields)}"
        raise UserError.of(f"observe: {channel.message.__name__} of '{channel.ref}' has no number '{field}'", hint)
    return channel, field


def _acts(graph: Graph, word: str) -> Channel:
    """Return the channel that an agent writes in place of a stage."""
    channel = _named(graph, word, "act")
    if channel is None:
        raise _unknown(graph, word, "act")
    node = graph.node(channel.stage)
    if node.is_source or node.stage_class.role == "score":
        what = f"act: '{node.name}' is {'a source' if node.is_source else 'a score'}, which no policy can replace"
        raise UserError.of(what, f"name the stage of a decision: {', '.join(_deciding(graph))}")
    if not numeric_of(channel) or _port_of(graph, channel).stamped:
        what = f"act: '{channel.ref}' is {channel.type_text}, which is not made of numbers at the stamp of its inputs"
        raise UserError.of(what, f"name another stage: {', '.join(_deciding(graph))}")
    for other in graph.nodes:
        for i in other.inputs:
            is_other = i.channel is not None and i.channel.stage == node.name and i.channel != channel
            if is_other and i.port.is_plain and i.channel is not None:
                what = (
                    f"act: '{other.name}' needs '{i.channel.ref}', which an agent that writes '{channel.ref}' does not"
                )
                raise UserError.of(what, f"name another stage: {', '.join(_deciding(graph))}")
    return channel


def _deciding(graph: Graph) -> list[str]:
    return [node.name for node in graph.order if node.outputs and node.stage_class.role != "score"]


def _named(graph: Graph, word: str, option: str) -> Channel | None:
    """Return the channel of ``stage.port``, of a name on the bus, or of a stage with one, None if there is none."""
    found = _matching(graph, word)
    if len(found) > 1 and option == "act":
        found = [channel for channel in found if channel.ref in graph.read]
    if len(found) > 1:
        what = f"{option}: '{word}' publishes {', '.join(channel.ref for channel in found)}"
        raise UserError.of(what, f"name one of them: {option}='{found[0].ref}'")
    return found[0] if found else None


def _matching(graph: Graph, word: str) -> list[Channel]:
    """Return the channel of ``stage.port`` or of a name on the bus, else those of a stage."""
    channels = list(graph.channels.values())
    named = [channel for channel in channels if word in (channel.ref, channel.name)]
    return named[:1] or [channel for channel in channels if channel.stage == word]


def _unknown(graph: Graph, word: str, option: str) -> UserError:
    hint = did_you_mean(word, [*graph.channels, *(node.name for node in graph.order)])
    return UserError.of(
        f"{option}: {graph.path.stem} has no channel {word!a}", hint or f"channels are {', '.join(graph.channels)}"
    )


def _default_image(graph: Graph) -> Channel:
    for node in graph.sources:
        for channel in node.outputs.values():
            if channel.message.__name__ == "Image":
                return channel
    raise UserError.of(f"{graph.path.stem} has no camera", f"name what to observe: {', '.join(graph.channels)}")


def _default_act(graph: Graph) -> Channel:
    """Return the command of the robot, before the guard if there is one: what it lets through is the graph's."""
    if not graph.commands:
        raise UserError.of(f"{graph.path.stem} is not a closed loop: no command reaches a world", _CLOSED)
    channel = graph.commands[0]
    while graph.node(channel.stage).stage_class.is_guard:
        before = next(_commands_of(graph.node(channel.stage)), None)
        if before is None:
            break
        channel = before
    return channel


def _commands_of(guard: Node) -> Iterator[Channel]:
    """Yield the commands that a guard passes on."""
    for i in guard.inputs:
        if i.port.is_plain and i.port.message is Twist and i.channel is not None:
            yield i.channel
