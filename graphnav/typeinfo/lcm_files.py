"""The files that LCM's wheel installs: tools, jars."""

from __future__ import annotations

from importlib.metadata import PackageNotFoundError, files
from pathlib import Path

from graphnav.errors import GraphnavError


def file_of_lcm(name: str) -> Path:
    """Return a file that the package ``lcm`` installed; of a tool the program itself, not the script that starts it.

    Raises
    ------
    GraphnavError
        There is none.
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
