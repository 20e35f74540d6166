"""Check that the installed plugins can be imported."""

from __future__ import annotations

from collections.abc import Iterator

from graphnav.core.catalog import Catalog
from graphnav.core.errors import CatalogError
from graphnav.develop.doctor.finding import Finding


def families() -> Iterator[Finding]:
    """Import every family of stages."""
    catalog = Catalog()
    for family in catalog.families():
        try:
            names = catalog.names(family)
        except CatalogError as error:
            yield Finding(
                f"family {family}", fine=False, seen=error.what, fix=str(error.hint) or "reinstall its package"
            )
        else:
            yield Finding(f"family {family}", fine=True, seen=", ".join(names) or "no stages")
