"""The parts of a checked graph: channels, inputs, settings, nodes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from types import MappingProxyType
from typing import Any, Literal

from graphnav.core.adapter import Adapter
from graphnav.core.codec import Codec, codec_of
from graphnav.core.errors import ParamError, Place, Problem
from graphnav.core.messages import Message
from graphnav.core.ros2 import RosType
from graphnav.core.stage import LiveSource, Port, Source, Stage, ports_of

SET: Literal["--set"] = "--set"
"""The origin of what an override gives, wherever it was written."""
Origin = Literal["graph", "default", "--set"]
"""Where the value of a parameter comes from."""


@dataclass(frozen=True)
class Channel:
    """The LCM channel of one output port, or of an input that another program writes."""

    ref: str
    """``stage.port``, as graphs refer to it."""
    name: str
    """The name on the bus: the same, unless ``channels`` renames it."""
    message: type[Message]

    @property
    def stage(self) -> str:
        """The stage that writes it, the stem of an input."""
        return self.ref.rpartition(".")[0]

    @property
    def type_text(self) -> str:
        """The name of its message type; a question mark where the stage that writes it is left out."""
        return "?" if self.message is Message else self.message.__name__

    @property
    def port(self) -> str:
        """The output port that writes it, the port of an input."""
        return self.ref.rpartition(".")[2]


@dataclass(frozen=True)
class Input:
    """An input port and the channel that feeds it, None for an unconnected `Latest`."""

    port: Port
    channel: Channel | None
    note: str = ""
    """How a swap came to this wire, empty if the graph says it."""


@dataclass(frozen=True)
class InputChannel:
    """A channel that another program writes, or a recorded one that is played at its stamps."""

    channel: Channel
    """The consumed channel: its ``ref`` and its ``name`` in logs are the name that the graph gives the input."""
    name: str
    """The LCM channel or the ROS 2 topic that is listened to; of a log, the channel in it."""
    lcm_class: type
    """The type on the wire; of a ROS 2 topic that of the message."""
    type_name: str
    """``package.type_t``"""
    adapter: Adapter | None
    """Converts the type into the channel's message; None where the message class wraps the type itself."""
    max_age_s: float | None
    """Older than this, the input counts as lost; None: a few of its periods."""
    log: Path | None
    """The log that is played, None for a channel that is listened to."""
    place: Place
    log_written: Path | None = None
    """The same as the graph gives it."""
    log_anywhere: Path | None = None
    """The same so that it holds in any folder."""
    ros_type: RosType | None = None
    """Of a ROS 2 topic, whose name is ``name``; None for an LCM channel."""

    @property
    def codec(self) -> Codec | RosType:
        """Decodes its messages."""
        return self.ros_type or codec_of(self.lcm_class)

    @property
    def is_channel(self) -> bool:
        """Whether it is heard by LCM: neither a log nor a ROS 2 topic."""
        return self.log is None and self.ros_type is None

    @property
    def sender(self) -> str:
        """Origin of its stamps: inputs of one sender may have equal stamps, those of two never do."""
        return self.channel.stage if self.log is None else str(self.log)


@dataclass(frozen=True)
class OutputChannel:
    """A channel that a live graph sends to other programs, with everything that sending needs."""

    channel: Channel
    name: str
    """The LCM channel or the ROS 2 topic on which it leaves."""
    lcm_class: type
    type_name: str
    adapter: Adapter | None
    """Converts the channel's message into the type on the wire; None where it is sent as it is."""
    motor: bool
    """Whether it moves something, so that a stop must follow when the run ends or hangs."""
    max_age_s: float
    """Of a motor channel: silence that lasts longer is answered by stops."""
    stop: Mapping[str, Any] | None
    """The fields of the stop message where the graph gives them; None: what becomes of ``Twist(0, 0)``."""
    place: Place
    ros_type: RosType | None = None
    """Of a ROS 2 topic, whose name is ``name``; None for an LCM channel."""

    @property
    def codec(self) -> Codec | RosType:
        """Encodes its messages."""
        return self.ros_type or codec_of(self.lcm_class)


@dataclass(frozen=True)
class Setting:
    """A parameter's value and where it came from."""

    value: Any
    """The value that the stage gets: of the declared type, paths resolved."""
    written: Any
    """The value as the graph gives it, paths not resolved."""
    anywhere: Any
    """The same with paths that hold in any folder."""
    origin: Origin
    place: Place
    """The value's place; that of the stage, for a default."""


@dataclass(frozen=True)
class Part:
    """A process of a run, and what follows if it ends before the run does."""

    name: str
    stages: tuple[str, ...]
    restart: Literal["never", "on_failure", "always"] = "never"
    max_restarts: int = 3
    """Restarts within ``restart_window_s``; after them it is given up."""
    restart_window_s: float = 60.0
    restart_delay_s: float = 0.5
    """The first; doubled with each further restart in the window."""
    host: str | None = None
    """Where it lives; None: where the command runs."""


class LeftOut(Stage):
    """Takes the place of a stage whose plugin is not trusted and so did not run: only its wires are known."""

    def step(self) -> None:
        """Never runs."""


@dataclass(frozen=True)
class Node:
    """A stage of a graph."""

    name: str
    use: str
    stage_class: type[Stage]
    settings: Mapping[str, Setting]
    """Every parameter, in the order of declaration."""
    inputs: tuple[Input, ...]
    outputs: Mapping[str, Channel]
    """By the name of the port, in the order of declaration."""
    place: Place
    every_ms: float | None = None
    """Live, the stage also fires this often; None: only when its plain inputs are complete."""
    deadline_ms: float | None = None
    """A step that ends later than this after its newest input was ready is counted as missed."""
    use_note: str = ""
    """The ``--set`` that put this stage here, empty if the graph says it."""
    time_notes: Mapping[str, str] = field(default_factory=dict)
    """Where ``every_ms`` and ``deadline_ms`` come from, if not from the graph."""

    @cached_property
    def params(self) -> Mapping[str, Any]:
        """Every parameter and the value that the stage gets."""
        return MappingProxyType({name: setting.value for name, setting in self.settings.items()})

    @property
    def family(self) -> str:
        """The family of its class."""
        return self.use.partition(".")[0]

    @property
    def has_since(self) -> bool:
        """Whether an input takes all messages since the last step."""
        return any(i.port.since for i in self.inputs)

    @property
    def output_ports(self) -> tuple[Port, ...]:
        """The output ports in the order of declaration."""
        return ports_of(self.stage_class).outputs

    @property
    def is_left_out(self) -> bool:
        """Whether its class is not known, because its plugin is not trusted."""
        return self.stage_class is LeftOut

    @property
    def is_source(self) -> bool:
        """Whether the clock fires it."""
        return issubclass(self.stage_class, Source)

    @property
    def is_live_source(self) -> bool:
        """Whether it is fired by what arrives from outside."""
        return issubclass(self.stage_class, LiveSource)

    @property
    def is_overridden(self) -> bool:
        """Whether ``--set`` put it here or gives one of its parameters."""
        return bool(self.use_note) or any(setting.origin == SET for setting in self.settings.values())

    @property
    def reproducible(self) -> tuple[Channel, ...]:
        """The channels that it makes again when it is stepped again, if it is a source (`Source.reproducible`)."""
        if not issubclass(self.stage_class, Source):
            return ()
        return tuple(self.outputs[port] for port in self.stage_class.reproducible)

    @property
    def writers(self) -> list[str]:
        """The stages, and the stems of inputs, whose messages fire it."""
        return [i.channel.stage for i in self.inputs if i.channel is not None and i.port.is_plain]

    def same_inputs(self, other: Node) -> frozenset[str]:
        """Return the input ports that both have, read alike from the same channel."""
        return frozenset(
            mine.port.name
            for mine in self.inputs
            if any(mine.port == i.port and mine.channel == i.channel for i in other.inputs)
        )

    def problem(self, error: ParamError) -> Problem:
        """Return a parameter's error as a problem at the parameter's place; a default is named, for it has none."""
        setting = self.settings.get(error.param)
        is_written = setting is not None and setting.origin != "default"
        what = error.what if is_written else f"default of '{error.param}': {error.what}"
        return Problem(setting.place if setting else self.place, f"{self.use}: {what}", error.hint)
