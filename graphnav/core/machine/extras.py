"""The extras of graphnav: their packages, and the command that installs them."""

from __future__ import annotations

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


def import_pandas(who: str) -> Any:
    """Return pandas, for ``who``.

    Raises
    ------
    UserError
        It is not installed.
    """
    try:
        import pandas  # noqa: ICN001 - an extra
    except ImportError as error:
        raise UserError.of(f"{who} needs pandas", install_command("pandas")) from error
    return pandas
