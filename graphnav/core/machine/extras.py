"""The extras of graphnav: their packages, and the command that installs them."""

from __future__ import annotations

import importlib
import shlex
from importlib.metadata import requires
from typing import Any

from packaging.requirements import Requirement

from graphnav.core.errors import UserError


def requirements_of(extra: str) -> list[Requirement]:
    """Return the packages of an extra of graphnav."""
    needed = [Requirement(line) for line in requires("graphnav") or ()]
    return [one for one in needed if one.marker is not None and one.marker.evaluate({"extra": extra})]


def install_command(extra: str) -> str:
    """Return the shell command that installs the packages of an extra, however graphnav was installed."""
    return f"pip install {shlex.join(f'{one.name}{one.specifier}' for one in requirements_of(extra))}"


def import_extra(module: str, extra: str, who: str, package: str = "") -> Any:
    """Return a module of an extra of graphnav, for ``who``; ``package``: as it is called, if not as it is imported.

    Raises
    ------
    UserError
        It is not installed.
    """
    imported = module.partition(".")[0]
    try:
        return importlib.import_module(module)
    except ModuleNotFoundError as error:
        if (error.name or "").partition(".")[0] != imported:
            raise
        raise UserError.of(f"{who} needs {package or imported}", install_command(extra)) from error


def import_pandas(who: str) -> Any:
    """Return pandas, for ``who``; raises as `import_extra`."""
    return import_extra("pandas", "pandas", who)
