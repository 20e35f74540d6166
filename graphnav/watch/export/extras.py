"""Import optional packages on demand; errors name the extra that installs them."""

from __future__ import annotations

import importlib
from typing import Any

from graphnav import UserError
from graphnav.core.machine import install_command

_EXTRAS = {"foxglove": ("foxglove", "foxglove-sdk"), "rerun": ("rerun", "rerun-sdk"), "pyarrow": ("parquet", "pyarrow")}
"""By imported package: the extra of graphnav that installs it, and its distribution name."""


def require(module: str, user: str = "this export") -> Any:
    """Return a module of an optional package needed by ``user``; raise UserError if it is not installed."""
    package = module.partition(".")[0]
    try:
        return importlib.import_module(module)
    except ModuleNotFoundError as error:
        if (error.name or "").partition(".")[0] != package:
            raise
        extra, name = _EXTRAS[package]
        hint = f"install it: {install_command(extra)}"
        raise UserError.of(f"{user} needs {name}, which is not installed", hint) from error
