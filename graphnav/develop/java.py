"""LCM types in Java, for lcm-spy and other Java programs: the tools of a JDK, the classes, and their jar in a cache."""

from __future__ import annotations

import hashlib
import json
import shlex
import shutil
import subprocess
import tempfile
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Final, NamedTuple

from graphnav import GraphnavError, UserError
from graphnav.core.machine import no_user_folder, user_folder
from graphnav.core.typeinfo import definition_files, file_of_lcm

_FULL = {
    "apt-get": "apt-get install -y default-jdk",
    "dnf": "dnf install -y java-latest-openjdk-devel",
    "pacman": "pacman -S jdk-openjdk",
    "zypper": "zypper install java-devel",
}
"""The command that installs a JDK with AWT, by package manager."""
_JAR = "types.jar"
_DEFAULT_PACKAGE = "lcmtypes"
_CACHE: Final = "XDG_CACHE_HOME"


@dataclass(frozen=True)
class Jdk:
    """The tools on the search path, None if missing; ``missing`` describes what is missing, else empty."""

    java: Path | None
    javac: Path | None
    jar: Path | None

    @property
    def missing(self) -> str:
        """A description of what is missing to build a jar of types and to open lcm-spy; empty if nothing is."""
        if self.java is None:
            return "Java is not installed"
        if self.javac is None or self.jar is None:
            return f"Java is installed, but no {'compiler (javac)' if self.javac is None else 'tool jar'}"
        if not _opens_windows(self.java):
            return "the installed Java is headless and cannot open windows"
        return ""


def find_jdk() -> Jdk:
    """Return the tools on the search path."""
    return Jdk(*(Path(found) if (found := shutil.which(name)) else None for name in ("java", "javac", "jar")))


def install_jdk() -> str:
    """Return the command that installs a complete JDK, as root."""
    return next((command for tool, command in _FULL.items() if shutil.which(tool)), "install a JDK with AWT")


def require_jdk() -> Jdk:
    """Return a complete JDK; raises UserError, with the command that installs one, if it is incomplete."""
    jdk = find_jdk()
    if jdk.missing:
        raise UserError.of(jdk.missing, f"run as root: {install_jdk()}")
    return jdk


def _opens_windows(java: Path) -> bool:
    """Whether AWT's library for X11 is installed; true if the directory layout is unknown."""
    home = java.resolve().parent.parent
    if not (home / "lib" / "modules").is_file():
        return True
    return (home / "lib" / "libawt_xawt.so").is_file()


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
        jar, classes = folder / _JAR, Path(scratch) / "classes"
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


def types_jar(lcm_classes: Iterable[type]) -> Path:
    """Return the jar of types and all nested types; build it unless the cache has one of the same content.

    Raises
    ------
    UserError
        No JDK is installed, or the cache cannot be written or has no folder.
    GraphnavError
        A tool fails, or is missing in the package ``lcm``.
    """
    classes = list(lcm_classes)
    jdk = require_jdk()
    content = [version("lcm"), str(jdk.javac and jdk.javac.resolve()), definition_files(classes)]
    key = hashlib.sha256(json.dumps(content).encode()).hexdigest()[:24]
    cache = user_folder(_CACHE)
    if cache is None:
        raise UserError.of("no folder for the jar of types", no_user_folder(_CACHE))
    folder = cache / "java"
    jar = folder / f"types-{key}.jar"
    try:
        if jar.is_file():
            return jar
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=folder) as scratch:
            write_java(classes, Path(scratch)).jar.replace(jar)
    except OSError as error:
        what = f"cannot write {folder}: {error.strerror}"
        raise UserError.of(what, f"set {_CACHE} to a writable folder") from error
    return jar
