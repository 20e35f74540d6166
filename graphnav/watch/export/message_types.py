"""Convert LCM fields to messages, with the installed adapters."""

from __future__ import annotations

from contextlib import suppress
from typing import Any

from graphnav import Adapter, Message
from graphnav.core.catalog import Catalog
from graphnav.core.codec import lcm_name, message_class_of
from graphnav.core.errors import CatalogError
from graphnav.core.interrupts import CtrlC


class MessageTypes:
    """Converts LCM types by an adapter, else by the message class that wraps them."""

    def __init__(self, catalog: Catalog) -> None:
        self._adapters: dict[str, Adapter] = {}
        with suppress(CatalogError):
            self._adapters = dict(catalog.adapters().readers)

    def message_type(self, lcm_class: type) -> type[Message] | None:
        """Return the message class for an LCM type, None if there is none."""
        adapter = self._adapters.get(lcm_name(lcm_class))
        return adapter.message if adapter is not None else message_class_of(lcm_class)

    def message(self, lcm_class: type, fields: dict[str, Any]) -> Message | None:
        """Return the message for the fields of an LCM type, None if they cannot be converted."""
        adapter = self._adapters.get(lcm_name(lcm_class))
        wrapper = message_class_of(lcm_class)
        try:
            if adapter is not None:
                return adapter.from_lcm(fields)
            return wrapper.from_lcm_fields(fields) if wrapper is not None else None
        except CtrlC:
            raise
        except BaseException:  # noqa: BLE001 - an adapter of a plugin, and bytes of any program
            return None
