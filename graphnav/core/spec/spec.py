"""Read a graph: the shape of its values is checked here, their meaning against the catalog later."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path

from graphnav.core.errors import Place, Problem
from graphnav.core.spec.outside import TIME_KEYS, InputSpec, OutputSpec, OutsideWords, QueueSpec
from graphnav.core.spec.value import Entry, Value
from graphnav.core.spec.yaml import parse_yaml

GRAPH_KEYS = ("about", "extends", "plugins", "run", "stages", "channels", "inputs", "outputs", "queues")
STAGE_KEYS = ("use", "with", "in", *TIME_KEYS)
STAGE_NAME = re.compile(r"[a-z][a-z0-9_]*")
RESERVED_STAGES = ("run",)
"""No stage is called so: ``--set run.seed=1`` means the option."""


@dataclass
class StageSpec:
    """One of ``stages``."""

    name: str
    place: Place
    use: str
    use_place: Place
    params: dict[str, Entry] = field(default_factory=dict)
    wires: dict[str, Entry] = field(default_factory=dict)
    """By input port; the value is a string, the reference."""
    times: dict[str, Entry] = field(default_factory=dict)
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


@dataclass
class Spec:
    """A graph as it is written."""

    about: str = ""
    run: dict[str, Entry] = field(default_factory=dict)
    stages: dict[str, StageSpec] = field(default_factory=dict)
    stages_place: Place | None = None
    channels: dict[str, Entry] = field(default_factory=dict)
    """By reference; the value is a string, the channel's name."""
    inputs: dict[str, InputSpec] = field(default_factory=dict)
    outputs: dict[str, OutputSpec] = field(default_factory=dict)
    queues: dict[str, QueueSpec] = field(default_factory=dict)
    folders: dict[str, Path] = field(default_factory=dict)
    """The folder of each file of the graph, by the file's name in places: paths are relative to it."""


def parse_spec(value: Value) -> tuple[Spec, list[Problem]]:
    """Return a graph as it is written, and everything that is wrong with its shape."""
    parser = _Parser()
    return parser.graph(value), parser.problems


def outline_of(data: bytes, source: str) -> Spec:
    """Return what the bytes of one graph file say, as far as it can be read; nothing is checked or loaded.

    For graphs that others announce: the size is bounded, no file is opened and no plugin runs.

    Raises
    ------
    UserError
        They are not YAML, or beyond a limit of `parse_yaml`.
    """
    return parse_spec(parse_yaml(data, source)[0])[0]


class _Parser(OutsideWords):
    def graph(self, value: Value) -> Spec:
        spec = Spec()
        if value.data is None:
            self._problem(value.place, "the graph is empty", "write stages: and what they use")
            return spec
        words = self._mapping(value, "a graph")
        if deploy := words.pop("deploy", None):
            what = "'deploy' is not supported yet: all stages of a graph run in one process"
            self._problem(deploy.place, what, "remove it; for several processes, connect graphs by inputs and outputs")
        self._known(words, GRAPH_KEYS, "a graph")
        if "about" in words:
            spec.about = self._text(words["about"].value, "'about'")
        spec.run = self._section(words, "run")
        if "stages" in words:
            spec.stages_place = words["stages"].place
            spec.stages = self._stages(words["stages"])
        elif isinstance(value.data, dict):
            self._problem(value.place, "the graph has no 'stages'", "write stages: and what they use")
        spec.channels = self._section(words, "channels")
        for ref, entry in spec.channels.items():
            self._text(entry.value, f"the channel name of '{ref}'")
        spec.inputs, spec.outputs, spec.queues = self._inputs(words), self._outputs(words), self._queues(words)
        return spec

    def _stages(self, entry: Entry) -> dict[str, StageSpec]:
        stages = self._mapping(entry.value, "'stages'")
        if not stages and isinstance(entry.value.data, dict | None):
            self._problem(entry.place, "the graph has no stages", "write a name and what it uses")
        return {name: spec for name, stage in stages.items() if (spec := self._stage(name, stage))}

    def _stage(self, name: str, entry: Entry) -> StageSpec | None:
        if not STAGE_NAME.fullmatch(name):
            self._problem(
                entry.place,
                f"'{name}' cannot be a stage's name",
                "use small letters, digits and _, beginning with a letter",
            )
        if name in RESERVED_STAGES:
            self._problem(entry.place, f"no stage can be called '{name}'", f"'--set {name}.…' means the options")
        if isinstance(entry.value.data, str):
            self._problem(
                entry.value.place,
                f"stage '{name}' must be a mapping, not {entry.value.kind}",
                f"write {name}: {{use: {entry.value.data}}}",
            )
            return None
        words = self._mapping(entry.value, f"stage '{name}'")
        if not isinstance(entry.value.data, dict | None):
            return None
        unclear = not self._known(words, STAGE_KEYS, f"stage '{name}'")
        if "use" not in words or words["use"].value.data in (None, ""):
            self._problem(entry.place, f"stage '{name}' does not say what it uses", "write use: family.stage")
            return None
        use_entry = words["use"]
        use = use_entry.value
        wires = self._section(words, "in", f"'in' of stage '{name}'")
        for port, wire in wires.items():
            self._text(wire.value, f"the wire of '{name}.{port}'", "write stage.port")
        return StageSpec(
            name=name,
            place=entry.place,
            use=self._text(use, f"'use' of stage '{name}'", "write family.stage"),
            use_place=use.place,
            params=self._section(words, "with", f"'with' of stage '{name}'"),
            wires={port: wire for port, wire in wires.items() if isinstance(wire.value.data, str)},
            unwired={port for port, wire in wires.items() if not isinstance(wire.value.data, str)},
            times=self.times(words, f"stage '{name}'"),
            has_timer="every_ms" in words,
            unclear=unclear
            or any(not isinstance(words[word].value.data, dict | None) for word in ("with", "in") if word in words),
        )
