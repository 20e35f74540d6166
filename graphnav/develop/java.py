"""Generate LCM types in Java for lcm-spy and other Java programs."""

from __future__ import annotations

import shlex
import shutil
import subprocess
import tempfile
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import NamedTuple

from graphnav import GraphnavError
from graphnav.core.typeinfo import definition_files, file_of_lcm

JAR = "types.jar"
_DEFAULT_PACKAGE = "lcmtypes"


class JavaTypes(NamedTuple):
    """The written sources, and the jar if a compiler is installed; ``commands`` build it elsewhere."""

    sources: tuple[Path, ...]
    jar: Path
    is_built: bool
    commands: tuple[str, ...]


def write_java(lcm_classes: Iterable[type], folder: Path) -> JavaTypes:
    """Write types and all nested types as Java into ``folder``, and a jar of them if ``javac`` is installed.

    Raises
    ------
    GraphnavError
        lcm-gen or lcm.jar of the package ``lcm`` is missing, or a tool fails.
    OSError
        The folder cannot be written.
    """
    lcm_gen, lcm_jar = file_of_lcm("lcm-gen"), file_of_lcm("lcm.jar")
    texts = definition_files(lcm_classes)
    folder.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as scratch:
        definitions = [Path(scratch) / name for name in texts]
        for definition in definitions:
            definition.write_text(texts[definition.name], encoding="utf-8")
        _run([str(lcm_gen), "-j", "--jpath", str(folder), *map(str, definitions)])
        sources = tuple(_source(folder, name.removesuffix(".lcm")) for name in texts)
        jar, classes = folder / JAR, Path(scratch) / "classes"
        javac, jar_tool = shutil.which("javac"), shutil.which("jar")
        if javac is not None and jar_tool is not None:
            compiling, packing = _build(javac, jar_tool, lcm_jar, classes, sources, jar)
            _run(compiling)
            _run(packing)
            return JavaTypes(sources, jar, is_built=True, commands=())
    commands = _build("javac", "jar", lcm_jar, folder / "classes", sources, jar)
    return JavaTypes(sources, jar, is_built=False, commands=tuple(map(shlex.join, commands)))


def _source(folder: Path, lcm_type: str) -> Path:
    """Return the path to which lcm-gen writes a type; Java has no types outside packages."""
    package, _, name = lcm_type.rpartition(".")
    return folder.joinpath(*(package or _DEFAULT_PACKAGE).split("."), f"{name}.java")


def _build(
    javac: str, jar_tool: str, lcm_jar: Path, classes: Path, sources: Sequence[Path], jar: Path
) -> tuple[list[str], list[str]]:
    """Return the commands that compile the sources and pack the classes."""
    compiling = [javac, "-cp", str(lcm_jar), "-d", str(classes), *map(str, sources)]
    return compiling, [jar_tool, "cf", str(jar), "-C", str(classes), "."]


def _run(command: Sequence[str]) -> None:
    done = subprocess.run(command, capture_output=True, text=True, check=False)  # noqa: S603, paths of our own
    if done.returncode:
        output = (done.stderr or done.stdout).strip().splitlines()
        raise GraphnavError(f"{Path(command[0]).name} failed: {output[0] if output else f'status {done.returncode}'}")
