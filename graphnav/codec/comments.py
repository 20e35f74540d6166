"""What the definition of an LCM type says in comments and constants."""

from __future__ import annotations

import ast
import inspect
import itertools
from typing import Any

_TYPE_LINE = "LCM Type:"


def comments_of(lcm_class: type) -> dict[str, str]:
    """Return the comment above each field that has one, on one line; lcm-gen 1.5 writes them into its Python.

    Empty if the source is not there, or was made by an older lcm-gen.
    """
    try:
        (struct,) = ast.parse(inspect.getsource(lcm_class)).body
    except (OSError, TypeError, SyntaxError, ValueError):
        return {}
    init = next((part for part in getattr(struct, "body", []) if getattr(part, "name", "") == "__init__"), None)
    body = getattr(init, "body", [])
    comments: dict[str, str] = {}
    for statement, text in itertools.pairwise(body):
        match statement, text:
            case ast.Assign(targets=[ast.Attribute(attr=name)]), ast.Expr(value=ast.Constant(value=str(found))):
                lines = [line.strip() for line in found.splitlines()]
                if comment := " ".join(line for line in lines if line and not line.startswith(_TYPE_LINE)):
                    comments[name] = comment
    return comments


def constants_of(lcm_class: type) -> dict[str, Any]:
    """Return the constants that a type defines, which are not on the wire."""
    return {
        name: value
        for name, value in vars(lcm_class).items()
        if not name.startswith("_") and isinstance(value, int | float) and name not in getattr(lcm_class, "__slots__")  # noqa: B009
    }
