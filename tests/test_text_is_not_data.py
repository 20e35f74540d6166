"""No code splits, searches or compares the wording of a message, as far as the syntax shows it."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
FILES = [path for folder in ("graphnav", "plugins") for path in sorted((ROOT / folder).rglob("*.py"))]
MESSAGES = {"what", "hint"}
TAKES_APART = {
    *("split", "rsplit", "splitlines", "partition", "rpartition", "startswith", "endswith"),
    *("removeprefix", "removesuffix", "replace", "find", "index", "count", "strip", "lower", "casefold"),
}
ALLOWED = {
    "graphnav/core/errors.py": "indents the lines of a hint",
    "plugins/graphnav_world/maps/map_text.py": "PyYAML gives a reason only as the first line of its message",
}


def is_message(node: ast.expr, errors: set[str]) -> bool:
    """Return whether an expression is ``x.what``, ``x.hint`` or ``str(error)`` of a caught error."""
    if isinstance(node, ast.Attribute):
        return node.attr in MESSAGES
    is_text = isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in {"str", "repr"}
    return is_text and any(isinstance(n, ast.Name) and n.id in errors for n in ast.walk(node))


def uses(tree: ast.AST) -> Iterator[int]:
    """Yield the lines in which a message is compared, searched, split or indexed."""
    errors = {h.name for h in ast.walk(tree) if isinstance(h, ast.ExceptHandler) and h.name} | {"error", "problem"}
    for node in ast.walk(tree):
        parts: list[ast.expr] = []
        if isinstance(node, ast.Compare):
            parts = [node.left, *node.comparators]
        elif isinstance(node, ast.Subscript):
            parts = [node.value]
        elif isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute):
            is_re = isinstance(node.func.value, ast.Name) and node.func.value.id == "re"
            parts = node.args if is_re else [node.func.value] if node.func.attr in TAKES_APART else []
        if any(is_message(part, errors) for part in parts):
            yield getattr(node, "lineno", 0)


def test_messages_are_not_taken_apart() -> None:
    names = {file.relative_to(ROOT).as_posix(): file for file in FILES}
    found = [
        f"{name}:{line}" for name in names.keys() - ALLOWED.keys() for line in uses(ast.parse(names[name].read_text()))
    ]
    assert not found, "\n" + "\n".join(sorted(found))


@pytest.mark.parametrize(
    "code",
    [
        "'a' in error.what",
        "problem.hint.split('\\n')",
        "str(error).startswith('x')",
        "str(error)[0]",
        "re.match('a', p.what)",
    ],
)
def test_what_takes_a_message_apart_is_seen(code: str) -> None:
    assert list(uses(ast.parse(code))) == [1]
