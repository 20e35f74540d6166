"""The formats of files that plugins read."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from graphnav.core.errors import CatalogError
from graphnav.core.spec.declared.file_format import FileFormat

if TYPE_CHECKING:
    from graphnav.core.catalog import Catalog


def plugin_formats(catalog: Catalog) -> dict[str, FileFormat[Any]]:
    """Return the formats of all installed plugins, which are imported, by name.

    Raises
    ------
    CatalogError
        A plugin cannot be imported, does not return formats, or returns one of a name that another one has.
    """
    for family in catalog.families():
        catalog.load(family)
    found: dict[str, FileFormat[Any]] = {}
    for hook in catalog.hook.graphnav_file_formats.get_hookimpls():
        origin = hook.plugin_name.partition(": ")[2]
        given = catalog.called(origin, "graphnav_file_formats()", hook.function)
        if not isinstance(given, list | tuple) or not all(isinstance(one, FileFormat) for one in given):
            what = f"{origin}: graphnav_file_formats() does not return a list of FileFormat"
            raise CatalogError(what, "return [FileFormat(...)]")
        for one in given:
            if one.name in found:
                raise CatalogError(f"{origin}: there is another file format '{one.name}'", "give it another name")
            found[one.name] = one
    return found
