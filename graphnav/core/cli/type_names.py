"""Find LCM types by name: those of graphnav, of plugins and of installed packages."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from typing import TYPE_CHECKING

from graphnav.core.errors import CatalogError, UserError

if TYPE_CHECKING:
    from graphnav.core.catalog import Catalog


_OWN_PACKAGE = "graphnav_lcm."


def short_type(name: str) -> str:
    """Return ``flow_t`` for ``graphnav_lcm.flow_t``, as tables show it; types of other packages keep their package."""
    return name.removeprefix(_OWN_PACKAGE)


class KnownTypes:
    """The LCM types that a command knows: of graphnav, of plugins, and those ``given`` by ``--types``, by LCM name."""

    def __init__(self, catalog: Catalog, given: Mapping[str, type]) -> None:
        self._catalog, self._given = catalog, given

    def called(self, name: str) -> type:
        """Return the lcm-gen class of a type or message; plugins are imported only if it is unknown without them.

        Raises
        ------
        UserError
            The type does not exist.
        """
        from graphnav.core.codec import find_type

        with suppress(UserError):
            return find_type(name, self._given)
        self._catalog.load_types()
        return find_type(name, {**_adapted(self._catalog), **self._given})

    def every(self) -> dict[str, type]:
        """Return the types of graphnav, of the messages of all plugins, of adapters and those given, by LCM name."""
        from graphnav.core.codec import SHIPPED, lcm_name, message_classes

        self._catalog.load_types()
        found = [*SHIPPED, *(message.lcm_class for message in message_classes())]
        return {lcm_name(lcm_class): lcm_class for lcm_class in found} | _adapted(self._catalog) | dict(self._given)


def _adapted(catalog: Catalog) -> dict[str, type]:
    """Return the third-party types that adapters read or write, and their nested types, by LCM name."""
    from graphnav.core.codec import lcm_name
    from graphnav.core.typeinfo import nested_types

    found: dict[str, type] = {}
    with suppress(CatalogError):
        adapters = catalog.adapters()
        for name, adapter in {**adapters.readers, **adapters.writers}.items():
            found |= {lcm_name(nested): nested for nested in nested_types(adapter.lcm_class)}
            found[name] = adapter.lcm_class
    return found
