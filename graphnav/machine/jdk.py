"""Java on this machine: which tools there are, whether it opens windows, what installs the rest."""

from __future__ import annotations

import shutil
from dataclasses import dataclass
from pathlib import Path

from graphnav.errors import UserError

_FULL = {
    "apt-get": "apt-get install -y default-jdk",
    "dnf": "dnf install -y java-latest-openjdk-devel",
    "pacman": "pacman -S jdk-openjdk",
    "zypper": "zypper install java-devel",
}
"""A JDK that also opens windows, by the program that installs packages."""


@dataclass(frozen=True)
class Jdk:
    """The tools on the search path, None if one is not; ``lacks`` says in words what is missing, else empty."""

    java: Path | None
    javac: Path | None
    jar: Path | None

    @property
    def lacks(self) -> str:
        """What is missing for building a jar of types and for lcm-spy's window."""
        if self.java is None:
            return "Java is not installed"
        if self.javac is None or self.jar is None:
            return f"there is a Java runtime, but no {'compiler (javac)' if self.javac is None else 'tool jar'}"
        if not _opens_windows(self.java):
            return "the installed Java is a headless one, which opens no window"
        return ""


def find_jdk() -> Jdk:
    """Return what the search path finds."""
    return Jdk(*(Path(found) if (found := shutil.which(name)) else None for name in ("java", "javac", "jar")))


def install_jdk() -> str:
    """Return the command that installs what is missing, as root."""
    return next((command for tool, command in _FULL.items() if shutil.which(tool)), "install a JDK with AWT")


def require_jdk() -> Jdk:
    """Return a complete JDK; raises UserError, with the command that installs one, if it is not."""
    jdk = find_jdk()
    if jdk.lacks:
        raise UserError.of(jdk.lacks, f"run as root: {install_jdk()}")
    return jdk


def _opens_windows(java: Path) -> bool:
    """Whether AWT's library for X11 is there; true where the layout is not known."""
    home = java.resolve().parent.parent
    if not (home / "lib" / "modules").is_file():
        return True
    return (home / "lib" / "libawt_xawt.so").is_file()
