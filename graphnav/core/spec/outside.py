"""Read the inputs, outputs and queues of a graph."""

from __future__ import annotations

import re
from dataclasses import dataclass

from graphnav.core.errors import Place, Problem
from graphnav.core.spec.shape import Shapes
from graphnav.core.spec.value import Entry, Value

INPUT_KEYS = ("channel", "log", "type", "max_age_s")
OUTPUT_KEYS = ("channel", "type", "motor", "max_age_s", "stop")
QUEUE_KEYS = ("keep",)
TIME_KEYS = ("every_ms", "deadline_ms")
"""Times of a stage."""
INPUT_NAME = re.compile(r"[a-z][a-z0-9_]*\.[a-z][a-z0-9_]*")
MIN_EVERY_MS, MAX_EVERY_MS = 1, 60_000
STOP_AFTER_S = 0.5
"""Silence of a motor channel that is answered by stops, unless the graph sets it."""
MAX_STOP_AFTER_S = 5.0
"""Upper limit of a motor output's ``max_age_s``: a robot without commands for longer is not under control."""
MAX_INPUT_AGE_S = 60.0


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

    @property
    def channel_name(self) -> str:
        """The LCM channel, or that in the log; empty where the reference is meant."""
        return "" if self.channel is None else str(self.channel.value.data)


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
    unclear: bool = False
    """Whether something is wrong with it, so that what seems missing may be in it."""


@dataclass(frozen=True)
class QueueSpec:
    """One of ``queues``."""

    place: Place
    keep: int | None
    """None: as many as memory allows."""


class OutsideWords(Shapes):
    """Parses ``inputs``, ``outputs``, ``queues`` and the times of a stage."""

    def _inputs(self, words: dict[str, Entry]) -> dict[str, InputSpec]:
        found = {ref: self._input(ref, entry) for ref, entry in self._section(words, "inputs").items()}
        return {ref: spec for ref, spec in found.items() if spec is not None}

    def _input(self, ref: str, entry: Entry) -> InputSpec | None:
        who = f"the input '{ref}'"
        words = self._mapping(entry.value, who)
        if "keep" in words and not {"channel", "log", "type"} & words.keys():
            what = f"'inputs' names channels that other programs write, but '{ref}' has the keys of a queue"
            keep = words["keep"].value.data
            keep = keep if isinstance(keep, int | str) else "all"
            self._problem(entry.place, what, f"write queues: {{{ref}: {{keep: {keep}}}}}")
            return None
        spec = InputSpec(entry.place)
        if not INPUT_NAME.fullmatch(ref):
            hint = "write stem.port in small letters, digits and _, as in camera.image"
            self._problem(entry.place, f"'{ref}' cannot be the name of an input", hint)
            return spec
        if not isinstance(entry.value.data, dict | None):
            return spec
        is_known = self._known(words, INPUT_KEYS, who)
        spec.type = self._text_entry(words, "type", who)
        spec.channel, spec.log = self._text_entry(words, "channel", who), self._text_entry(words, "log", who)
        if is_known and not {"channel", "log"} & words.keys():
            hint = f"write {ref}: {{channel: NAME, type: package.type_t}}, or log: FILE in place of the channel"
            self._problem(entry.place, f"{who} does not say where it comes from", hint)
        elif is_known and "type" not in words:
            self._problem(entry.place, f"{who} does not say what it carries", "write type: package.type_t")
        if "max_age_s" in words:
            spec.max_age_s = self._age(words["max_age_s"].value, who, MAX_INPUT_AGE_S)
        return spec

    def _outputs(self, words: dict[str, Entry]) -> dict[str, OutputSpec]:
        return {ref: self._output(ref, entry) for ref, entry in self._section(words, "outputs").items()}

    def _output(self, ref: str, entry: Entry) -> OutputSpec:
        who = f"the output '{ref}'"
        before = len(self.problems)
        words = self._mapping(entry.value, who)
        spec = OutputSpec(entry.place)
        if isinstance(entry.value.data, dict | None):
            is_known = self._known(words, OUTPUT_KEYS, who)
            if is_known and "channel" not in words:
                what = f"{who} does not say on which channel it leaves"
                self._problem(entry.place, what, f"write {ref}: {{channel: NAME}}")
            spec.channel, spec.type = self._text_entry(words, "channel", who), self._text_entry(words, "type", who)
            if "motor" in words:
                spec.motor = self._switch(words["motor"].value, f"'motor' of {who}")
            if "max_age_s" in words:
                spec.max_age_s = self._age(words["max_age_s"].value, who, MAX_STOP_AFTER_S) or STOP_AFTER_S
            if "stop" in words:
                spec.stop = self._stop(words["stop"], who)
                if not spec.motor and ("motor" not in words or words["motor"].value.data is False):
                    what = f"{who} has a 'stop', but is not a motor output"
                    self._problem(words["stop"].place, what, "write motor: true, or remove the stop")
        spec.unclear = len(self.problems) > before
        return spec

    def _stop(self, entry: Entry, who: str) -> Entry | None:
        if isinstance(entry.value.data, dict) and entry.value.data:
            return entry
        kind = entry.value.kind if entry.value.data else "empty"
        what = f"'stop' of {who} must be a mapping of LCM fields, not {kind}"
        self._problem(entry.value.place, what, "write stop: {field: value}")
        return None

    def _queues(self, words: dict[str, Entry]) -> dict[str, QueueSpec]:
        found = {ref: self._queue(ref, entry) for ref, entry in self._section(words, "queues").items()}
        return {ref: spec for ref, spec in found.items() if spec is not None}

    def _queue(self, ref: str, entry: Entry) -> QueueSpec | None:
        who = f"the queue of '{ref}'"
        words = self._mapping(entry.value, who)
        if not isinstance(entry.value.data, dict | None):
            return QueueSpec(entry.place, None)
        is_known = self._known(words, QUEUE_KEYS, who)
        if "keep" not in words:
            if is_known:
                self._problem(entry.place, f"{who} does not say how much it holds", "write keep: all, or a number")
            return QueueSpec(entry.place, None)
        value = words["keep"].value
        if value.data == "all" and isinstance(value.data, str):
            return QueueSpec(entry.place, None)
        if isinstance(value.data, int) and not isinstance(value.data, bool) and value.data >= 1:
            return QueueSpec(entry.place, value.data)
        self._problem(value.place, f"'keep' of {who} must be all or an integer from 1, not {value.kind}")
        return QueueSpec(entry.place, None)

    def times(self, words: dict[str, Entry], who: str) -> dict[str, Entry]:
        """Return the valid times of a stage, by key."""
        limits = {
            "every_ms": (
                f"a number from {MIN_EVERY_MS} to {MAX_EVERY_MS}",
                lambda ms: MIN_EVERY_MS <= ms <= MAX_EVERY_MS,
            ),
            "deadline_ms": ("a number above 0", lambda ms: ms > 0),
        }
        return {
            key: words[key]
            for key, (wanted, fits) in limits.items()
            if key in words and self._number(words[key].value, f"'{key}' of {who}", wanted, fits) is not None
        }

    def _text_entry(self, words: dict[str, Entry], key: str, who: str) -> Entry | None:
        if key not in words:
            return None
        entry = words[key]
        hint = "write package.type_t" if key == "type" else "put it in quotes if it is meant"
        if self._text(entry.value, f"'{key}' of {who}", hint):
            return entry
        if entry.value.data == "":
            self._problem(entry.value.place, f"'{key}' of {who} is empty", "write a name")
        return None

    def _age(self, value: Value, who: str, max_s: float) -> float | None:
        wanted = f"a number of seconds above 0, at most {max_s:g}"
        return self._number(value, f"'max_age_s' of {who}", wanted, lambda seconds: 0 < seconds <= max_s)

    def _switch(self, value: Value, who: str) -> bool:
        if isinstance(value.data, bool):
            return value.data
        self._problem(value.place, f"{who} must be true or false, not {value.kind}")
        return False


def parse_times(words: dict[str, Entry], who: str) -> tuple[dict[str, Entry], list[Problem]]:
    """Return the valid times of a stage, by key, and what is wrong with the others."""
    parser = OutsideWords()
    return parser.times(words, who), parser.problems
