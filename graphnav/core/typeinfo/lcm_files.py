"""Find the files installed by LCM's wheel: tools, jars."""

from __future__ import annotations

from importlib.metadata import PackageNotFoundError, files
from pathlib import Path

from graphnav.core.errors import GraphnavError


def file_of_lcm(name: str) -> Path:
    """Return the path of a file of the package ``lcm``; for a tool the binary itself, not its wrapper script.

    Raises
    ------
    GraphnavError
        There is no such file.
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
