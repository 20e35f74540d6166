"""Load the LCM types of installed adapters."""

from __future__ import annotations

from contextlib import suppress

from graphnav.catalog import Catalog
from graphnav.errors import CatalogError


def load_adapted_types() -> None:
    """Import the installed adapters, which registers their types; broken adapters are skipped."""
    with suppress(CatalogError):
        Catalog().adapters()
