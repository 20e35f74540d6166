"""Read YAML so that every value keeps its place, with PyYAML's traps closed."""

from __future__ import annotations

from typing import Any

import yaml

from graphnav.errors import Place, Problem, UserError
from graphnav.spec.scalar import parse_scalar
from graphnav.spec.value import Entry, Value

MAX_BYTES = 256 * 1024
MAX_VALUES = 20_000
MAX_DEPTH = 20

_PLAIN = "plain"
_PREFIX = "tag:yaml.org,2002:"
_SAYINGS = (
    ("'\\t'", "a tab cannot stand here", "use spaces"),
    ("nest more than", "{what}", "flatten it"),
    ("expected a single document", "a second document begins here", "keep one graph in a file, without '---' between"),
    ("flow mapping: expected ','", "the '{{' of line {line} is not closed", "write '}' or a comma before this"),
    ("flow sequence: expected ','", "the '[' of line {line} is not closed", "write ']' or a comma before this"),
    ("expected <block end>", "this is indented otherwise than its block, which begins in line {line}", "align it"),
    ("mapping values are not allowed", "a ':' cannot stand here", "put a text that holds ': ' in quotes"),
    ("unexpected end of stream", "the quote of line {line} is not closed", "write the closing quote"),
    ("could not find expected ':'", "the key of line {line} has no ':'", "write ': ' after the key"),
    ("undefined alias", "{what}", "write out what is meant, without & and *"),
)
"""What PyYAML says (a part of it), what we say, and what to do."""
_KNOWN_TAGS = (_PLAIN, f"{_PREFIX}str", f"{_PREFIX}seq", f"{_PREFIX}map")


class _TooDeep(yaml.MarkedYAMLError):
    """Nesting beyond reason."""


class _Composer(yaml.SafeLoader):
    """Composes nodes; marks scalars as plain or quoted instead of guessing their type; limits depth."""

    _depth = 0

    def compose_node(self, parent: Any, index: Any) -> Any:
        if self._depth > MAX_DEPTH:
            mark = self.peek_event().start_mark  # type: ignore[no-untyped-call]
            raise _TooDeep(None, None, f"values nest more than {MAX_DEPTH} deep", mark)
        self._depth += 1
        try:
            return super().compose_node(parent, index)
        finally:
            self._depth -= 1

    def resolve(self, kind: Any, value: Any, implicit: Any) -> str:  # noqa: ARG002
        """Return the tag of a node without one."""
        if kind is yaml.ScalarNode:
            return _PLAIN if implicit[0] else f"{_PREFIX}str"
        return f"{_PREFIX}{'seq' if kind is yaml.SequenceNode else 'map'}"


class _Reader:
    """Turns nodes into values; aliases are followed, but may not explode."""

    def __init__(self, source: str) -> None:
        self.source = source
        self.problems: list[Problem] = []
        self._read = 0
        self._open: set[int] = set()

    def value(self, node: Any) -> Value:
        place = self.place(node)
        self._read += 1
        if self._read > MAX_VALUES:
            raise UserError.of(
                f"aliases make this more than {MAX_VALUES} values", "write out what is meant, without & and *", place
            )
        if node.tag not in _KNOWN_TAGS:
            tag = node.tag.replace(_PREFIX, "!!")
            self.problems.append(Problem(place, f"'{tag}' is a tag, and graphs have none", "leave the tag out"))
        if isinstance(node, yaml.ScalarNode):
            return Value(parse_scalar(node.value) if node.tag == _PLAIN else node.value, place)
        if id(node) in self._open:
            raise UserError.of("an alias stands inside what it stands for", "write out what is meant", place)
        self._open.add(id(node))
        try:
            if isinstance(node, yaml.SequenceNode):
                return Value([self.value(item) for item in node.value], place)
            return Value(self._mapping(node), place)
        finally:
            self._open.discard(id(node))

    def _mapping(self, node: Any) -> dict[str, Entry]:
        found: dict[str, Entry] = {}
        for key_node, value_node in node.value:
            key, entry = self.value(key_node), Entry(self.place(key_node), self.value(value_node))
            if not isinstance(key.data, str):
                hint = "" if isinstance(key.data, list | dict) else "put it in quotes if it is meant"
                self.problems.append(Problem(entry.place, f"a key must be a text, but this is {key.kind}", hint))
            elif key.data in found:
                first = found[key.data].place
                self.problems.append(
                    Problem(entry.place, f"'{key.data}' stands here again, first in line {first.line}", "keep one")
                )
            else:
                found[key.data] = entry
        return found

    def place(self, node: Any) -> Place:
        return Place(self.source, node.start_mark.line + 1, node.start_mark.column + 1)


def parse_yaml(data: bytes, source: str) -> tuple[Value, list[Problem]]:
    """Return what the bytes of a file say, and what is wrong with single values.

    ``source`` is the file as errors name it.

    Raises
    ------
    UserError
        It is no YAML, or beyond a limit (`MAX_BYTES`, `MAX_VALUES`, `MAX_DEPTH`).
    """
    text = _decoded(data, source)
    composer = None
    try:
        composer = _Composer(text)
        node = composer.get_single_node()
    except yaml.reader.ReaderError as error:
        raise UserError.of(
            f"the character U+{ord(text[error.position]):04X} cannot stand in YAML",
            "remove it; a graph is a text file",
            _place_of(text, error.position, source),
        ) from error
    except yaml.MarkedYAMLError as error:
        raise UserError([_syntax_problem(error, source)]) from error
    finally:
        if composer is not None:
            composer.dispose()
    if node is None:
        return Value(None, Place(source)), []
    reader = _Reader(source)
    value = reader.value(node)
    return value, reader.problems


def _decoded(data: bytes, source: str) -> str:
    if len(data) > MAX_BYTES:
        raise UserError.of(
            f"it has more than {MAX_BYTES} bytes, the most that a graph may have",
            "check that this is a graph",
            Place(source),
        )
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        place = _place_of(data[: error.start].decode("utf-8", "replace"), error.start, source)
        raise UserError.of(
            f"byte 0x{data[error.start]:02x} is not UTF-8", "save the file as UTF-8 text", place
        ) from error


def _place_of(text: str, position: int, source: str) -> Place:
    before = text[:position]
    return Place(source, before.count("\n") + 1, len(before) - before.rfind("\n"))


def _syntax_problem(error: yaml.MarkedYAMLError, source: str) -> Problem:
    mark, start = error.problem_mark or error.context_mark, error.context_mark
    place = Place(source, mark.line + 1, mark.column + 1) if mark else Place(source)
    what = (error.problem or error.context or "it cannot be read").strip()
    for part, said, hint in _SAYINGS:
        if part in f"{error.context}: {what}":
            return Problem(place, said.format(line=start.line + 1 if start else "?", what=what), hint)
    return Problem(place, f"YAML: {what}", error.context or "")
