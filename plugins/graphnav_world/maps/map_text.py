"""The text of a map: YAML nodes with their places, read value by value; all that is wrong is collected.

A number may be written as a range ``[low, high]``: it is then drawn from the seed. Each draw depends on the seed and
on where in the map it stands, not on other draws, so that a change in one place leaves the others as they are.
"""

from __future__ import annotations

import math
import zlib
from collections.abc import Collection, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from graphnav import Place, Problem, did_you_mean, shown_path

DEEPEST = 12


class MapText:
    """Reads values out of YAML nodes and notes every problem with its place."""

    def __init__(self, file: str, seed: int, attempt: int) -> None:
        self.file = file
        self.problems: list[Problem] = []
        self.drew = False
        self._seed, self._attempt = seed, attempt

    def rng(self, key: str) -> np.random.Generator:
        """Return the generator of one place of the map."""
        self.drew = True
        return np.random.default_rng([self._seed, self._attempt, zlib.crc32(key.encode())])

    def place(self, node: yaml.Node | None) -> Place:
        """Return where a node was written; the file itself for None."""
        if node is None:
            return Place(self.file)
        return Place(self.file, node.start_mark.line + 1, node.start_mark.column + 1)

    def wrong(self, node: yaml.Node | None, what: str, hint: str = "") -> None:
        """Note a problem."""
        self.problems.append(Problem(self.place(node), what, hint))

    def mapping(
        self, node: yaml.Node, what: str, known: Collection[str], required: Collection[str] = ()
    ) -> dict[str, yaml.Node]:
        """Return a mapping's known keys; note unknown, repeated and missing ones."""
        if not isinstance(node, yaml.MappingNode):
            self.wrong(node, f"{what} must be a mapping, not {_written(node)}", f"its keys are {_listed(known)}")
            return {}
        found: dict[str, yaml.Node] = {}
        lines: dict[str, int] = {}
        for key, value in node.value:
            name = str(key.value)
            if name in lines:
                self.wrong(key, f"{what} has '{name}' twice, first in line {lines[name]}", "keep one of them")
            elif name not in known:
                self.wrong(key, f"{what} has no '{name}'", _nearest(name, known))
            else:
                found[name] = value
            lines.setdefault(name, key.start_mark.line + 1)
        for name in required:
            if name not in lines:
                self.wrong(node, f"{what} needs '{name}'", f"add {name}: …")
        return found

    def items(self, node: yaml.Node, what: str) -> list[yaml.Node]:
        """Return the items of a list."""
        if not isinstance(node, yaml.SequenceNode):
            self.wrong(node, f"{what} must be a list, not {_written(node)}", "begin each item with '- '")
            return []
        return list(node.value)

    def entries(self, node: yaml.Node, what: str) -> dict[str, yaml.Node]:
        """Return a mapping whose keys are free names."""
        names = [str(key.value) for key, _ in node.value] if isinstance(node, yaml.MappingNode) else ["names"]
        return self.mapping(node, what, names)

    def span(
        self, node: yaml.Node, key: str, *, least: float = -math.inf, above: float = -math.inf, whole: bool = False
    ) -> tuple[float, float]:
        """Return the ends of a range, twice the same for a single number; NaN if it is neither."""
        name = _label(key)
        ends = [node]
        if isinstance(node, yaml.SequenceNode):
            if len(node.value) != 2:
                hint = "write one number, or a range [low, high]"
                self.wrong(node, f"{name} must be a number, not a list of {len(node.value)}", hint)
                return math.nan, math.nan
            ends = node.value
        numbers = [self._scalar(end, name, least, above, whole=whole) for end in ends]
        low, high = numbers[0], numbers[-1]
        if low > high:
            hint = f"write [{high:g}, {low:g}]"
            self.wrong(node, f"the range of {name} begins with its larger end", hint)
            return math.nan, math.nan
        return low, high

    def number(
        self, node: yaml.Node, key: str, *, least: float = -math.inf, above: float = -math.inf, whole: bool = False
    ) -> float:
        """Return a number, drawn if a range is written; NaN if it is none."""
        low, high = self.span(node, key, least=least, above=above, whole=whole)
        if low == high or math.isnan(low + high):
            return low + high - low
        rng = self.rng(key)
        return float(rng.integers(round(low), round(high) + 1)) if whole else float(rng.uniform(low, high))

    def pair(self, node: yaml.Node, key: str, *, above: float = -math.inf) -> tuple[float, float]:
        """Return two numbers, each of which may be a range."""
        name = _label(key)
        if not isinstance(node, yaml.SequenceNode) or len(node.value) != 2:
            self.wrong(node, f"{name} must be two numbers, not {_written(node)}", "write [x, y]")
            return math.nan, math.nan
        x, y = (self.number(part, f"{key}.{axis}", above=above) for part, axis in zip(node.value, "xy", strict=True))
        return x, y

    def flag(self, node: yaml.Node, key: str) -> bool:
        """Return true or false."""
        if isinstance(node, yaml.ScalarNode) and node.value in {"true", "false"}:
            return bool(node.value == "true")
        self.wrong(node, f"{_label(key)} must be true or false, not {_written(node)}")
        return False

    def word(self, node: yaml.Node, what: str, known: Collection[str]) -> str:
        """Return one of the known words; the first of them if it is none."""
        if isinstance(node, yaml.ScalarNode) and node.value in known:
            return str(node.value)
        hint = did_you_mean(str(node.value), known)
        self.wrong(node, f"{what} must be {_listed(known)}, not {_written(node)}", hint)
        return next(iter(known))

    def _scalar(self, node: yaml.Node, name: str, least: float, above: float, *, whole: bool) -> float:
        try:
            value = float(node.value) if isinstance(node, yaml.ScalarNode) and node.style is None else math.nan
        except ValueError:
            value = math.nan
        if not math.isfinite(value):
            self.wrong(node, f"{name} must be a number, not {_written(node)}", "write a number or a range [low, high]")
            return math.nan
        if whole and value != round(value):
            self.wrong(node, f"{name} must be a whole number, not {value:g}")
            return math.nan
        if value < least or value <= above:
            bound = f"at least {least:g}" if value < least else f"above {above:g}"
            self.wrong(node, f"{name} is {value:g}, but must be {bound}")
            return math.nan
        return value


def compose(path: Path) -> tuple[yaml.Node | None, list[Problem]]:
    """Return the root node of a YAML file, or None and what keeps it from being read."""
    file = shown_path(path)
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else "it is not text in UTF-8"
        return None, [Problem(Place(file), f"the map cannot be read: {reason}", "give a map's YAML file")]
    try:
        refused = _refused(text)
        if refused is not None:
            event, what, hint = refused
            return None, [Problem(_at(file, event.start_mark), what, hint)]
        root = yaml.compose(text, Loader=yaml.SafeLoader)
    except yaml.MarkedYAMLError as error:
        where = _at(file, error.problem_mark or error.context_mark)
        return None, [Problem(where, f"this is not YAML: {error.problem}", "check indentation, brackets and quotes")]
    except yaml.YAMLError as error:
        what = f"this is not YAML: {str(error).splitlines()[0]}"
        return None, [Problem(Place(file), what, "save the map as plain text in UTF-8")]
    if root is None:
        return None, [Problem(Place(file), "the map is empty", "give it at least a start")]
    return root, []


def _refused(text: str) -> tuple[yaml.Event, str, str] | None:
    """Return the first alias, over-deep nesting or second document: the event there, what, hint."""
    depth, documents = 0, 0
    for event in yaml.parse(text, Loader=yaml.SafeLoader):
        if isinstance(event, yaml.AliasEvent):
            return event, f"a map has no aliases, but here is *{event.anchor}", "write the value out"
        if isinstance(event, yaml.CollectionStartEvent):
            depth += 1
        elif isinstance(event, yaml.CollectionEndEvent):
            depth -= 1
        elif isinstance(event, yaml.DocumentStartEvent):
            documents += 1
        if depth > DEEPEST:
            return event, f"this is nested deeper than {DEEPEST} levels", "no map needs that"
        if documents > 1:
            return event, "a second document begins here", "a file holds one map"
    return None


def _at(file: str, mark: Any) -> Place:
    return Place(file, mark.line + 1, mark.column + 1) if mark else Place(file)


def numbered(nodes: Sequence[yaml.Node], key: str) -> Iterator[tuple[str, yaml.Node]]:
    """Yield the nodes of a list with the key of each."""
    for index, node in enumerate(nodes):
        yield f"{key}.{index}", node


def _label(key: str) -> str:
    """Return how messages name what a key stands for: ``'radius_m'``, ``x of 'center_m'``, ``a point of 'along'``."""
    *before, last = key.split(".")
    if last.isdigit():
        return f"a point of '{before[-1]}'"
    if last in {"x", "y"} and before:
        return f"{last} of '{next(name for name in reversed(before) if not name.isdigit())}'"
    return f"'{last}'"


def _listed(names: Collection[str]) -> str:
    *most, last = names
    return f"{', '.join(most)} or {last}" if most else last


def _nearest(name: str, known: Collection[str]) -> str:
    return did_you_mean(name, known) or f"use {_listed(known)}"


def _written(node: yaml.Node) -> str:
    if isinstance(node, yaml.MappingNode):
        return "a mapping"
    if isinstance(node, yaml.SequenceNode):
        return f"a list of {len(node.value)}"
    return f"'{node.value}'" if len(str(node.value)) <= 40 else "a long text"
