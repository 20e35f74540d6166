"""LCM's own tools: find them, run lcm-gen, and read the modules that it writes without importing them."""

from __future__ import annotations

import ast
import re
import subprocess
from collections.abc import Sequence
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, files
from pathlib import Path

from graphnav.core.errors import GraphnavError, Place, UserError, printable
from graphnav.core.typeinfo.definition_source import DefinitionSource

_TIMEOUT_S = 60.0
_TOP = (ast.Import, ast.ImportFrom, ast.ClassDef)
_BODY = (ast.Assign, ast.FunctionDef)
_STRING = ast.Constant


def generate_python(sources: Sequence[DefinitionSource], folder: Path, prefix: str) -> None:
    """Generate Python for all definitions in ``folder``, inside the package ``prefix``.

    Raises
    ------
    UserError
        lcm-gen rejects a definition.
    GraphnavError
        lcm-gen is not installed.
    """
    inputs = [folder / f"definition_{number}.lcm" for number in range(len(sources))]
    for path, source in zip(inputs, sources, strict=True):
        path.write_text(source.text, encoding="utf-8")
    command = [str(file_of_lcm("lcm-gen")), "-p", "--ppath", str(folder), "--package-prefix", prefix]
    try:
        done = subprocess.run(  # noqa: S603, a path of our own
            [*command, *map(str, inputs)], capture_output=True, timeout=_TIMEOUT_S, check=False
        )
    except subprocess.TimeoutExpired as error:
        what = f"lcm-gen did not finish within {_TIMEOUT_S:g} s"
        raise UserError.of(what, "give fewer definitions", Place("--types")) from error
    output = (done.stdout + done.stderr).decode("utf-8", "replace").strip("\n")
    if done.returncode or output:
        raise _error_of(output, done.returncode, dict(zip(inputs, sources, strict=True)), prefix)


def _error_of(output: str, status: int, sources: dict[Path, DefinitionSource], prefix: str) -> UserError:
    """Parse lcm-gen's error output: message, ``FILE : LINE``, that line, a caret below the column."""
    lines = output.splitlines()
    for number, line in enumerate(lines):
        for path, source in sources.items():
            if found := re.fullmatch(rf"{re.escape(str(path))} : (\d+)", line.strip()):
                caret = next((below for below in lines[number + 1 :] if below.strip() == "^"), "")
                place = Place(str(source.path), int(found[1]), caret.find("^") + 1)
                return UserError.of(f"lcm-gen: {_in_one_line(lines[:number], sources, prefix)}", place=place)
    output_text = _in_one_line(lines, sources, prefix) or f"exit status {status}"
    return UserError.of(f"lcm-gen: {output_text}", place=Place("--types"))


def _in_one_line(lines: Sequence[str], sources: dict[Path, DefinitionSource], prefix: str) -> str:
    """Return lcm-gen's output on one line, with the user's names of files and types."""
    text = " ".join(" ".join(lines).split())
    for path, source in sources.items():
        text = text.replace(str(path), str(source.path))
    return printable(text.replace(f"{prefix}.", ""))


def file_of_lcm(name: str) -> Path:
    """Return the path of a file of the package ``lcm``; for a tool the binary itself, not its wrapper script.

    Raises
    ------
    GraphnavError
        The file does not exist.
    """
    try:
        found = [file for file in files("lcm") or [] if file.name == name]
    except PackageNotFoundError:
        found = []
    for path in (Path(str(file.locate())) for file in sorted(found, key=lambda file: ".." in file.parts)):
        if path.is_file():
            return path
    raise GraphnavError(
        f"the installed package 'lcm' has no {name}\n  install its wheel: pip install --force-reinstall lcm"
    )


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
