"""Types of other packages that installed adapters explain."""

from __future__ import annotations

from contextlib import suppress

from graphnav.catalog import Catalog
from graphnav.errors import CatalogError


def load_adapted_types() -> None:
    """Import the installed adapters, which makes their types known; one that cannot be used adds none."""
    with suppress(CatalogError):
        Catalog().adapters()
