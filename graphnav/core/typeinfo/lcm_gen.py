"""Run lcm-gen for Python; its errors become UserErrors with file, line and column."""

from __future__ import annotations

import re
import subprocess
from collections.abc import Sequence
from pathlib import Path

from graphnav.core.errors import Place, UserError, printable
from graphnav.core.typeinfo.definition_source import DefinitionSource
from graphnav.core.typeinfo.lcm_files import file_of_lcm

_TIMEOUT_S = 60.0


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
