"""Find the Java tools on this machine, whether Java opens windows, and the command that installs the rest."""

from __future__ import annotations

import shutil
from dataclasses import dataclass
from pathlib import Path

from graphnav import UserError

_FULL = {
    "apt-get": "apt-get install -y default-jdk",
    "dnf": "dnf install -y java-latest-openjdk-devel",
    "pacman": "pacman -S jdk-openjdk",
    "zypper": "zypper install java-devel",
}
"""The command that installs a JDK with AWT, by package manager."""


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
