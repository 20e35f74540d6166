"""Read a Python module written by lcm-gen without importing it."""

from __future__ import annotations

import ast
from dataclasses import dataclass
from pathlib import Path

from graphnav.core.errors import UserError

_TOP = (ast.Import, ast.ImportFrom, ast.ClassDef)
_BODY = (ast.Assign, ast.FunctionDef)
_STRING = ast.Constant


@dataclass(frozen=True)
class GeneratedModule:
    """The type defined by a module: its LCM name, and the names and types of its fields in class order."""

    name: str
    slots: tuple[str, ...]
    typenames: tuple[str, ...]


def read_generated(path: Path, name: str) -> GeneratedModule:
    """Read the module that lcm-gen wrote for the type ``name``.

    Raises
    ------
    UserError
        The module is not valid Python, or does not define an LCM type.
    """
    try:
        tree = ast.parse(path.read_bytes())
    except (SyntaxError, ValueError) as error:
        raise UserError.of(
            f"Python cannot hold the type {name}: one of its names is a Python keyword",
            "rename the field, the type or the package",
        ) from error
    top = [node for node in tree.body if not _is_docstring(node)]
    classes = [node for node in top if isinstance(node, ast.ClassDef)]
    if len(classes) != 1 or not all(isinstance(node, _TOP) for node in top):
        raise UserError.of(f"the code that lcm-gen wrote for {name} does not define a type")
    body = [node for node in classes[0].body if not _is_docstring(node)]
    if not all(isinstance(node, _BODY) for node in body):
        raise UserError.of(f"the code that lcm-gen wrote for {name} does not define fields")
    lists = {
        target.id: ast.literal_eval(node.value)
        for node in body
        if isinstance(node, ast.Assign)
        for target in node.targets
        if isinstance(target, ast.Name) and target.id in {"__slots__", "__typenames__"}
    }
    return GeneratedModule(name, tuple(lists["__slots__"]), tuple(lists["__typenames__"]))


def _is_docstring(node: ast.stmt) -> bool:
    return isinstance(node, ast.Expr) and isinstance(node.value, _STRING)
