"""A graph as it is written: its shape is checked here, by the declared keys, its meaning against the catalog later."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TypeVar

from graphnav.core.errors import Place, Problem
from graphnav.core.spec.declared import key_problems, keys_of, read_record
from graphnav.core.spec.graph_keys import (
    FILE_KEYS,
    RESERVED_STAGES,
    SOURCE_KEYS,
    STOP_AFTER_S,
    GraphKeys,
    InputKeys,
    OutputKeys,
    PartKeys,
    Ros2Keys,
    StageKeys,
)
from graphnav.core.spec.value import Entry, Value
from graphnav.core.spec.yaml import parse_yaml

TIME_KEYS = ("every_ms", "deadline_ms")
"""Times of a stage."""
Words = dict[str, Entry]
"""A mapping of a file: keys and what is under them."""

T = TypeVar("T", bool, int, float, str)


@dataclass
class StageSpec:
    """One of ``stages``."""

    name: str
    place: Place
    use: str
    use_place: Place
    params: Words = field(default_factory=dict)
    wires: Words = field(default_factory=dict)
    """By input port; the value is a string, the reference."""
    times: Words = field(default_factory=dict)
    """``every_ms`` and ``deadline_ms`` where they are given; the value is a number."""
    has_timer: bool = False
    """Whether ``every_ms`` is written, right or wrong."""
    use_note: str = ""
    """The ``--set`` that swapped it, empty if the graph itself uses it."""
    wire_notes: dict[str, str] = field(default_factory=dict)
    """How swaps came to wires, by input port."""
    unwired: set[str] = field(default_factory=set)
    """Inputs that are known to be open, which has been said."""
    unclear: bool = False
    """Whether a key is unknown, or ``in`` or ``with`` is not a mapping: entries that seem missing may be in it."""

    def copied(self) -> StageSpec:
        """Return the same stage, whose changes leave this one as it is."""
        return replace(
            self,
            params=dict(self.params),
            wires=dict(self.wires),
            times=dict(self.times),
            wire_notes=dict(self.wire_notes),
            unwired=set(self.unwired),
        )


@dataclass
class InputSpec:
    """One of ``inputs``, without what is wrong."""

    place: Place
    type: Entry | None = None
    """The value is a string."""
    channel: Entry | None = None
    """The value is a string; None: the reference, in a log."""
    log: Entry | None = None
    """The value is a string."""
    max_age_s: float | None = None
    ros2: Entry | None = None
    """The value is a string, a topic."""

    @property
    def channel_name(self) -> str:
        """The LCM channel, the topic, or the channel in the log; empty where the reference is meant."""
        named = self.ros2 or self.channel
        return "" if named is None else str(named.value.data)


@dataclass
class OutputSpec:
    """One of ``outputs``, without what is wrong."""

    place: Place
    channel: Entry | None = None
    """The value is a string."""
    type: Entry | None = None
    """The value is a string; None: the type of the message itself."""
    motor: bool | None = None
    """None: the graph does not say."""
    max_age_s: float = STOP_AFTER_S
    stop: Entry | None = None
    """The value is a mapping."""
    ros2: Entry | None = None
    """The value is a string, a topic."""
    unclear: bool = False
    """Whether something is wrong with it, so that what seems missing may be in it."""


@dataclass(frozen=True)
class QueueSpec:
    """One of ``queues``."""

    place: Place
    keep: int | None
    """None: as many as memory allows."""


@dataclass
class PartSpec:
    """One of ``deploy``."""

    keys: PartKeys
    stages: list[tuple[str, Place | None]]
    """Names, with their places."""


@dataclass
class Spec:
    """A graph as it is written."""

    about: str = ""
    run: Words = field(default_factory=dict)
    stages: dict[str, StageSpec] = field(default_factory=dict)
    stages_place: Place | None = None
    channels: Words = field(default_factory=dict)
    """By reference; the value is the channel's name."""
    inputs: dict[str, InputSpec] = field(default_factory=dict)
    outputs: dict[str, OutputSpec] = field(default_factory=dict)
    queues: dict[str, QueueSpec] = field(default_factory=dict)
    deploy: dict[str, PartSpec] = field(default_factory=dict)
    ros2: Ros2Keys | None = None
    """None: the graph does not say."""
    folders: dict[str, Path] = field(default_factory=dict)
    """The folder of each file of the graph, by the file's name in places: paths are relative to it."""

    def copied(self) -> Spec:
        """Return the same graph, whose changes leave this one as it is."""
        return replace(
            self,
            run=dict(self.run),
            stages={name: stage.copied() for name, stage in self.stages.items()},
            channels=dict(self.channels),
            outputs=dict(self.outputs),
            queues=dict(self.queues),
            deploy={name: replace(part, stages=list(part.stages)) for name, part in self.deploy.items()},
            folders=dict(self.folders),
        )


def parse_spec(value: Value) -> tuple[Spec, list[Problem]]:
    """Return a graph as it is written, and everything that is wrong with its shape."""
    problems = list(_problems(value))
    spec, wrong = outline(value), {problem.place for problem in problems}
    for ref, entry in _section(_mapping(value), "outputs").items():
        words = _mapping(entry.value)
        places = [p for one in (entry, *words.values()) for p in (one.place, one.value.place)]
        spec.outputs[ref].unclear = not wrong.isdisjoint(places)
    return spec, problems


def time_problems(stage: str, key: str, value: Value) -> list[Problem]:
    """Return what is wrong with one of `TIME_KEYS` of a stage."""
    return key_problems(StageKeys, stage, key, value)


def outline_of(data: bytes, source: str) -> Spec:
    """Return what the bytes of one graph file say, as far as it can be read; nothing is checked or loaded.

    For graphs that others announce: the size is bounded, no file is opened and no plugin runs.

    Raises
    ------
    UserError
        They are not YAML, or beyond a limit of `parse_yaml`.
    """
    return outline(parse_yaml(data, source)[0])


def outline(value: Value) -> Spec:
    """Return what a graph says, as far as it can be read."""
    words = _mapping(value)
    stages = {name: _stage(name, entry) for name, entry in _section(words, "stages").items()}
    queues = {ref: _queue(entry) for ref, entry in _section(words, "queues").items()}
    return Spec(
        about=_data(words, "about", str) or "",
        run=_section(words, "run"),
        stages={name: stage for name, stage in stages.items() if stage is not None},
        stages_place=words["stages"].place if "stages" in words else None,
        channels=_section(words, "channels"),
        inputs={ref: _input(entry) for ref, entry in _section(words, "inputs").items() if not _is_queue(entry)},
        outputs={ref: _output(entry) for ref, entry in _section(words, "outputs").items()},
        queues=queues,
        ros2=read_record(Ros2Keys, words["ros2"].value)[0] if _section(words, "ros2") else None,
        deploy={name: part for name, entry in _section(words, "deploy").items() if (part := _part(entry))},
    )


def _stage(name: str, entry: Entry) -> StageSpec | None:
    """Return a stage; None for one that does not say what it uses."""
    words = _mapping(entry.value)
    if "use" not in words or words["use"].value.data in (None, ""):
        return None
    wires = _section(words, "in")
    sections = [words[key].value.data for key in ("with", "in") if key in words]
    return StageSpec(
        name=name,
        place=entry.place,
        use=_data(words, "use", str) or "",
        use_place=words["use"].value.place,
        params=_section(words, "with"),
        wires={port: wire for port, wire in wires.items() if isinstance(wire.value.data, str)},
        unwired={port for port, wire in wires.items() if not isinstance(wire.value.data, str)},
        times={key: words[key] for key in TIME_KEYS if _number(words, key) is not None},
        has_timer="every_ms" in words,
        unclear=not words.keys() <= keys_of(StageKeys).keys() or not all(isinstance(s, dict | None) for s in sections),
    )


def _input(entry: Entry) -> InputSpec:
    words = _mapping(entry.value)
    channel, log, lcm_type = (_string(words, key) for key in ("channel", "log", "type"))
    return InputSpec(entry.place, lcm_type, channel, log, _number(words, "max_age_s"), _string(words, "ros2"))


def _is_queue(entry: Entry) -> bool:
    """Return whether an entry of ``inputs`` has the keys of a queue, as it had in older versions."""
    words = _mapping(entry.value)
    return "keep" in words and not {*SOURCE_KEYS, "type"} & words.keys()


def _output(entry: Entry) -> OutputSpec:
    words = _mapping(entry.value)
    max_age_s = _number(words, "max_age_s")
    return OutputSpec(
        entry.place,
        _string(words, "channel"),
        _string(words, "type"),
        _data(words, "motor", bool) if "motor" in words else None,
        STOP_AFTER_S if max_age_s is None else max_age_s,
        words.get("stop") if _section(words, "stop") else None,
        _string(words, "ros2"),
    )


def _queue(entry: Entry) -> QueueSpec:
    return QueueSpec(entry.place, _data(_mapping(entry.value), "keep", int))


def _part(entry: Entry) -> PartSpec | None:
    keys = read_record(PartKeys, entry.value)[0]
    if keys is None:
        return None
    return PartSpec(keys, [(stage, keys.place("stages", str(k))) for k, stage in enumerate(keys.stages)])


def _problems(value: Value) -> Iterator[Problem]:
    """Yield what is wrong with the shape of a graph; options of the run are read once overrides are applied."""
    if value.data is None:
        yield Problem(value.place, "the graph is empty", "write stages: and what they use")
        return
    words = {key: entry for key, entry in _mapping(value).items() if key not in FILE_KEYS}
    yield from _reserved_names(_section(words, "stages"))
    yield from _lacking_sources(_section(words, "inputs"))
    yield from _idle_stops(_section(words, "outputs"))
    yield from _lacking_targets(_section(words, "outputs"))
    for kind in ("input", "output"):
        yield from _two_names(kind, _section(words, f"{kind}s"))
    if _section(words, "run"):
        del words["run"]
    if inputs := _section(words, "inputs"):
        inputs = {ref: entry for ref, entry in inputs.items() if not _is_queue(entry)}
        words["inputs"] = Entry(words["inputs"].place, Value(inputs, words["inputs"].value.place))
    yield from read_record(GraphKeys, Value(words, value.place) if isinstance(value.data, dict) else value)[1]


def _reserved_names(stages: Words) -> Iterator[Problem]:
    for name in RESERVED_STAGES:
        if name in stages:
            hint = f"'--set {name}.…' means the options"
            yield Problem(stages[name].place, f"no stage can be called '{name}'", hint)


def _lacking_sources(inputs: Words) -> Iterator[Problem]:
    """Yield what is wrong with inputs that do not say where they come from."""
    for ref, entry in inputs.items():
        words = _mapping(entry.value)
        if _is_queue(entry):
            what = f"'inputs' names channels that other programs write, but '{ref}' has the keys of a queue"
            keep = words["keep"].value.data
            keep = keep if isinstance(keep, int | str) else "all"
            yield Problem(entry.place, what, f"write queues: {{{ref}: {{keep: {keep}}}}}")
        elif isinstance(entry.value.data, dict | None) and words.keys() <= keys_of(InputKeys).keys() - SOURCE_KEYS:
            hint = (
                f"write {ref}: {{channel: NAME, type: package.type_t}}, or log: FILE or ros2: /topic in place of the "
                "channel"
            )
            yield Problem(entry.place, f"the input '{ref}' does not say where it comes from", hint)


def _idle_stops(outputs: Words) -> Iterator[Problem]:
    """Yield the stops of outputs that are not motors."""
    for ref, entry in outputs.items():
        words = _mapping(entry.value)
        motor = _data(words, "motor", bool) if "motor" in words else False
        if "stop" in words and motor is False:
            what = f"the output '{ref}' has a 'stop', but is not a motor output"
            yield Problem(words["stop"].place, what, "write motor: true, or remove the stop")


def _lacking_targets(outputs: Words) -> Iterator[Problem]:
    """Yield the outputs that do not say where they leave."""
    for ref, entry in outputs.items():
        words = _mapping(entry.value)
        if isinstance(entry.value.data, dict | None) and words.keys() <= keys_of(OutputKeys).keys() - SOURCE_KEYS:
            what = f"the output '{ref}' does not say on which channel it leaves"
            yield Problem(entry.place, what, "write channel: NAME, or ros2: /topic")


def _two_names(kind: str, entries: Words) -> Iterator[Problem]:
    """Yield the topics beside a channel or a log; ``kind``: ``input`` or ``output``."""
    for ref, entry in entries.items():
        words = _mapping(entry.value)
        others = [key for key in ("channel", "log") if key in words]
        if "ros2" in words and others:
            what = f"the {kind} '{ref}' has a {others[0]} and a ROS 2 topic"
            yield Problem(words["ros2"].place, what, f"remove '{others[0]}' or 'ros2'")


def _mapping(value: Value) -> Words:
    """Return a mapping, empty where there is something else."""
    return value.data if isinstance(value.data, dict) else {}


def _section(words: Words, key: str) -> Words:
    """Return a copy of the mapping under a key, empty where there is none."""
    return dict(_mapping(words[key].value)) if key in words else {}


def _data(words: Words, key: str, kind: type[T]) -> T | None:
    """Return the scalar under a key, None where there is none of the kind."""
    data = words[key].value.data if key in words else None
    return data if type(data) is kind else None


def _string(words: Words, key: str) -> Entry | None:
    return words[key] if _data(words, key, str) else None


def _number(words: Words, key: str) -> float | None:
    number = _data(words, key, float)
    return _data(words, key, int) if number is None or not math.isfinite(number) else number
