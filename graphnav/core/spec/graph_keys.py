"""Declared keys of a graph's file.

Keys that may be left out, but are not null, have None as their default without saying so in their type.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar, Literal

from graphnav.core.ros2 import LOOPBACK, MAX_DOMAIN, TOPIC_PATTERN
from graphnav.core.spec.declared import FileFormat, Names, Record, key
from graphnav.core.spec.run import RunKeys
from graphnav.core.spec.value import Value

STAGE_NAME = r"[a-z][a-z0-9_]*"
RESERVED_STAGES = ("run",)
"""No stage is called so: ``--set run.seed=1`` means the option."""
FILE_KEYS = ("extends", "plugins")
"""Read file by file, before the files of a graph are merged."""
SOURCE_KEYS = {"channel", "log", "ros2"}
"""One of them says where an input comes from; what leaves has no log."""
STOP_AFTER_S = 0.5
"""Silence of a motor channel that is answered by stops, unless the graph sets it."""
MAX_STOP_AFTER_S = 5.0
"""Upper limit of a motor output's ``max_age_s``: a robot without commands for longer is not under control."""

_PORT = rf"{STAGE_NAME}\.{STAGE_NAME}"
_CHANNEL = r"(?!graphnav\.)[!-~]{1,63}"
_TYPE = r"[A-Za-z_][A-Za-z0-9_]*([./][A-Za-z_][A-Za-z0-9_]*)*"
_PORTS = Names(_PORT)
_INPUTS = Names(_PORT, "the name of an input", "write stem.port in small letters, digits and _, as in camera.image")
_PARTS = Names(STAGE_NAME, "a process's name", "use small letters, digits and _, beginning with a letter")
_STAGES = Names(STAGE_NAME, "a stage's name", "use small letters, digits and _, beginning with a letter")


class StageKeys(Record):
    """A stage. Order matters in one way: sources due at the same time fire in the order of the file."""

    noun = "a stage"
    named = "stage '{}'"
    short = "use"
    example = "flow: {use: flow.lucas_kanade, with: {layers: 3}, in: {image: robot.image}}"

    use: str = key(
        not_empty=True, missing="does not say what it uses", doc="`family.stage`", hint="write use: family.stage"
    )
    params: Mapping[str, Value] | None = key(None, name="with", doc="parameters")
    wires: Mapping[str, str] | None = key(
        None, name="in", doc="what each input reads: `stage.port`", hint="write stage.port"
    )
    every_ms: float = key(None, ge=1, le=60_000, doc="live, the stage also fires this often; lockstep does not use it")
    deadline_ms: float = key(
        None, gt=0, doc="a step that ends later than this after its newest input is counted as missed"
    )


class InputKeys(Record):
    """A channel that another program writes, or one of a log, which is played at its stamps."""

    noun = "an input"
    named = "the input '{}'"
    conditions: ClassVar[Mapping[str, Any]] = {
        "anyOf": [
            {"required": ["log"]},
            {"required": ["ros2"]},
            {"properties": {"channel": {"pattern": f"^{_CHANNEL}$"}}, "required": ["channel"]},
        ]
    }
    example = "camera.image: {channel: CAMERA, type: graphnav_lcm.image_t}"

    channel: str = key(
        None, not_empty=True, doc="the LCM channel that another program writes; of a log, the channel in it"
    )
    log: str = key(None, not_empty=True, doc="a log that is played at its stamps")
    ros2: str = key(
        None, not_empty=True, doc="in place of `channel`, the ROS 2 topic that another program publishes: `/name`"
    )
    type: str = key(
        not_empty=True,
        pattern=_TYPE,
        missing="does not say what it carries",
        doc="the LCM type on the wire, `package.type_t`; of a topic the ROS 2 type, `package/Type`",
        hint="write type: package.type_t",
    )
    max_age_s: float = key(
        None, gt=0, le=60, doc="older than this, the input counts as lost; default: a few of its periods"
    )


class OutputKeys(Record):
    """A channel that leaves a live graph."""

    noun = "an output"
    named = "the output '{}'"
    conditions: ClassVar[Mapping[str, Any]] = {
        "dependentSchemas": {"stop": {"properties": {"motor": {"const": True}}, "required": ["motor"]}},
        "anyOf": [{"required": ["channel"]}, {"required": ["ros2"]}],
    }
    example = "guard.twist: {channel: BASE, motor: true}"

    channel: str = key(
        None,
        not_empty=True,
        pattern=_CHANNEL,
        doc="the LCM channel on which it leaves",
        hint="write channel: NAME",
    )
    ros2: str = key(
        None,
        not_empty=True,
        pattern=TOPIC_PATTERN,
        doc="in place of `channel`, the ROS 2 topic on which it leaves: `/name`",
        hint="write ros2: /name",
    )
    type: str = key(
        None,
        not_empty=True,
        pattern=_TYPE,
        doc="the LCM type on the wire, `package.type_t`; default: that of the message. Of a topic the ROS 2 type, "
        "`package/Type`; default: the only one that carries the message",
        hint="write type: package.type_t",
    )
    motor: bool = key(default=False, doc="whether it moves something: stops follow it; a Twist has to say")
    max_age_s: float = key(
        STOP_AFTER_S, gt=0, le=MAX_STOP_AFTER_S, doc="silence of a motor channel that is answered by stops"
    )
    stop: Mapping[str, Value] = key(
        None, min_items=1, doc="the fields of the stop message", hint="write stop: {field: value}"
    )


class Ros2Keys(Record):
    """Where the ROS 2 programs are that publish and subscribe the topics of a graph."""

    noun = "ros2"
    named = "ros2"
    example = "ros2: {domain: 3, interface: eth0}"

    domain: int = key(None, ge=0, le=MAX_DOMAIN, doc="the domain of the ROS programs; default: `ROS_DOMAIN_ID`, else 0")
    interface: str = key(
        LOOPBACK, not_empty=True, doc="the network interface on which they are; lo: programs of this machine alone"
    )


class PartKeys(Record):
    """A process in which some stages of a run live; what goes in and out of it follows from the wires."""

    noun = "a process"
    named = "the process '{}'"
    example = "eyes: {stages: [flow, plane], restart: on_failure}"

    stages: tuple[str, ...] = key(
        min_items=1,
        not_empty=True,
        missing="does not say which stages live in it",
        doc="the stages that live in it; those that no process names stay in that of the command",
        hint="write stages: [NAME]",
    )
    restart: Literal["never", "on_failure", "always"] = key(
        "never",
        doc="what follows if the process ends before the run does: on_failure starts it again if it was killed or "
        "ended with another exit status than 0, always in any case; in lockstep it is fed its inputs again, so that "
        "the log stays the same, live it begins at the next stamp. Otherwise the run fails",
    )
    max_restarts: int = key(3, ge=1, le=1000, doc="how often it is started again within `restart_window_s`")
    restart_window_s: float = key(60.0, gt=0, le=1e6, doc="the time in which restarts are counted")
    restart_delay_s: float = key(
        0.5, ge=0, le=600, doc="wait before a restart; twice as long before each further one in `restart_window_s`"
    )
    host: str = key(
        None,
        pattern=STAGE_NAME,
        doc="the host on which it lives, as `hosts.yaml` names it; without one it lives where the command runs",
        hint="write host: jetson",
    )


class QueueKeys(Record):
    """The messages that wait at an input of a stage: every complete set of them fires, live."""

    noun = "a queue"
    named = "the queue of '{}'"
    example = "plane.flow: {keep: all}"

    keep: Literal["all"] | int = key(
        ge=1,
        missing="does not say how much it holds",
        doc="how many messages wait; all: as many as memory allows",
        hint="write keep: all, or a number from 1",
    )


class GraphKeys(Record):
    """`stages` may be left out where the graph extends another one."""

    noun = "a graph"
    conditions: ClassVar[Mapping[str, Any]] = {"allOf": [{"properties": {"extends": {"uniqueItems": True}}}]}

    about: str = key("", doc="what the graph does, in a sentence")
    extends: str | tuple[str, ...] = key(
        None,
        min_items=1,
        not_empty=True,
        doc="a graph, beside this one or one that ships, whose values those of this one override; or a list of them, "
        "in which each one overrides those before it",
    )
    plugins: tuple[str, ...] | None = key(None, not_empty=True, doc="files with stages, relative to this one")
    run: RunKeys | None = key(None, doc="how the graph runs, unless the command line says otherwise")
    stages: Mapping[str, StageKeys] = key(
        min_items=1, names=_STAGES, missing="has no 'stages'", doc="by name", hint="write stages: and what they use"
    )
    ros2: Ros2Keys | None = key(None, doc="where the ROS 2 programs are, for inputs and outputs that are ROS 2 topics")
    channels: Mapping[str, str] | None = key(
        None, pattern=_CHANNEL, names=_PORTS, doc="LCM channels with another name than `stage.port`"
    )
    inputs: Mapping[str, InputKeys] | None = key(
        None, names=_INPUTS, doc="channels that other programs write, which makes the graph live"
    )
    outputs: Mapping[str, OutputKeys] | None = key(
        None, names=_PORTS, doc="channels that leave a live graph, by `stage.port`; lockstep does not use it"
    )
    deploy: Mapping[str, PartKeys] | None = key(
        None, names=_PARTS, doc="processes and the stages that live in them; without it, one process"
    )
    queues: Mapping[str, QueueKeys] | None = key(
        None, names=_PORTS, doc="by `stage.port`, inputs of stages of which every complete set fires, live"
    )


GRAPH = FileFormat(
    "graph",
    GraphKeys,
    title="Graphs",
    doc="""
A graph is a YAML file (YAML 1.2: `1e-3` is a number, `on` and `no` are strings). `graphnav check FILE` reports
everything that is wrong with one, with line and column; `graphnav schema > graph.schema.json` prints the JSON
Schema, with which editors complete and check a graph while you write it.

```yaml
about: A camera that looks at the floor.
run: {until_s: 60, seed: 7}
stages:
  robot: {use: world.pymunk, with: {map: maps/corridor_ccw.yaml}}
  flow:  {use: flow.lucas_kanade, in: {image: robot.image}}
```

Names of stages are lower-case letters, digits and `_`, beginning with a letter. A channel is called `stage.port`;
`stage` alone is enough where the stage has one output. Paths are relative to the file that contains them.

Of a graph that `extends` others, mappings are merged key by key; anything else is replaced. `null` removes a stage, a
wire or an entry of a section. A stage whose `use` changes is swapped as `--set` would swap it: wires of ports with the
same name and type stay. Of a list each graph overrides those before it; a file that several of them extend is read
once, where it comes first. `parts/NAME` that ships, or a file of yours, may contain some stages only.
""",
)
