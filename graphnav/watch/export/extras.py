"""Import optional packages on demand; errors name the extra that installs them."""

from __future__ import annotations

from typing import Any

from graphnav import import_extra

_EXTRAS = {"foxglove": ("foxglove", "foxglove-sdk"), "rerun": ("rerun", "rerun-sdk"), "pyarrow": ("parquet", "pyarrow")}
"""By imported package: the extra of graphnav that installs it, and its distribution name."""


def require(module: str, user: str = "this export") -> Any:
    """Return a module of an optional package needed by ``user``; raise UserError if it is not installed."""
    extra, name = _EXTRAS[module.partition(".")[0]]
    return import_extra(module, extra, user, name)
