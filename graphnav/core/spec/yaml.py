"""Read YAML so that every value keeps its place, with PyYAML's traps closed."""

from __future__ import annotations

import errno
from pathlib import Path
from typing import Any

import yaml

from graphnav.core.errors import Place, Problem, UserError
from graphnav.core.machine.files import read_regular
from graphnav.core.spec.value import Entry, Value, parse_scalar

MAX_BYTES = 256 * 1024
MAX_VALUES = 12_000
MAX_DEPTH = 20

_PLAIN = "plain"
_PREFIX = "tag:yaml.org,2002:"
_SAYINGS = (
    ("'\\t'", "a tab is not allowed here", "use spaces"),
    ("flow mapping: expected ','", "the '{{' of line {line} is not closed", "write '}' or a comma before this"),
    ("flow sequence: expected ','", "the '[' of line {line} is not closed", "write ']' or a comma before this"),
    ("expected <block end>", "inconsistent indentation: the block begins in line {line}", "align it"),
    ("mapping values are not allowed", "a ':' is not allowed here", "put a string that contains ': ' in quotes"),
    ("unexpected end of stream", "the quote of line {line} is not closed", "write the closing quote"),
    ("could not find expected ':'", "the key of line {line} has no ':'", "write ': ' after the key"),
)
"""Part of PyYAML's message, which has no code, with ours and the fix."""
_KNOWN_TAGS = (_PLAIN, f"{_PREFIX}str", f"{_PREFIX}seq", f"{_PREFIX}map")


class _Composer(yaml.SafeLoader):
    """Composes nodes; marks scalars as plain or quoted instead of guessing their type; limits depth."""

    def __init__(self, text: str, source: str) -> None:
        super().__init__(text)
        self._source, self._depth = source, 0

    def compose_root(self) -> Any:
        """Return the root node of the one document, None without one."""
        if not self.check_node():
            return None
        root = self.get_node()
        if self.check_node():
            hint = "keep one document in a file, without '---' between"
            raise UserError.of("a second document begins here", hint, self._place())
        return root

    def compose_node(self, parent: Any, index: Any) -> Any:
        """Return the next node, with those in it."""
        if self._depth > MAX_DEPTH:
            raise UserError.of(f"values are nested more than {MAX_DEPTH} deep", "flatten it", self._place())
        if self.check_event(yaml.AliasEvent) and self.peek_event().anchor not in self.anchors:  # type: ignore[no-untyped-call]
            what = f"undefined alias '{self.peek_event().anchor}'"  # type: ignore[no-untyped-call]
            raise UserError.of(what, "write the value out, without & and *", self._place())
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

    def _place(self) -> Place:
        mark = self.peek_event().start_mark  # type: ignore[no-untyped-call]
        return Place(self._source, mark.line + 1, mark.column + 1)


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
                f"the file has more than {MAX_VALUES} values, aliases expanded", "make it smaller", place
            )
        if node.tag not in _KNOWN_TAGS:
            tag = node.tag.replace(_PREFIX, "!!")
            self.problems.append(Problem(place, f"the tag '{tag}' is not supported", "leave it out"))
        if isinstance(node, yaml.ScalarNode):
            return Value(parse_scalar(node.value) if node.tag == _PLAIN else node.value, place)
        if id(node) in self._open:
            raise UserError.of("recursive alias", "write the value out, without & and *", place)
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
                self.problems.append(Problem(entry.place, f"a key must be a string, not {key.kind}", hint))
            elif key.data in found:
                first = found[key.data].place
                what = f"duplicate entry '{key.data}', first in line {first.line}"
                self.problems.append(Problem(entry.place, what, "keep one"))
            else:
                found[key.data] = entry
        return found

    def place(self, node: Any) -> Place:
        return Place(self.source, node.start_mark.line + 1, node.start_mark.column + 1)


def parse_yaml(data: bytes, source: str) -> tuple[Value, list[Problem]]:
    """Return what the bytes of a file contain, and what is wrong with single values.

    ``source`` is the file as errors name it.

    Raises
    ------
    UserError
        It is not YAML, or beyond a limit (`MAX_BYTES`, `MAX_VALUES`, `MAX_DEPTH`).
    """
    text = _decoded(data, source)
    composer = None
    try:
        composer = _Composer(text, source)
        node = composer.compose_root()
    except yaml.reader.ReaderError as error:
        raise UserError.of(
            f"the character U+{ord(text[error.position]):04X} is not allowed in YAML",
            "remove it, or name a text file",
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


def too_large(n_bytes: int, place: Place, who: str = "it") -> UserError:
    """Return the error for a file, called ``who``, of more than `MAX_BYTES`."""
    what = f"{who} has {n_bytes} bytes, but a YAML file that graphnav reads has at most {MAX_BYTES}"
    return UserError.of(what, "check that this is the file that you mean", place)


def _decoded(data: bytes, source: str) -> str:
    if len(data) > MAX_BYTES:
        raise too_large(len(data), Place(source))
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


def read_bytes(path: Path, place: Place, who: str = "it") -> bytes:
    """Return the content of a YAML file; ``who``: the file as errors call it.

    Raises
    ------
    UserError
        It cannot be read, is not a regular file, or is larger than `MAX_BYTES`; shown at ``place``.
    """
    try:
        return read_regular(path, MAX_BYTES)
    except OSError as error:
        if error.errno == errno.EFBIG:
            raise too_large(path.stat().st_size, place, who) from error
        raise UserError.of(f"{who} cannot be read: {error.strerror}", place=place) from error
