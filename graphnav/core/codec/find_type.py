"""Find an LCM type by any of its names: ``Flow``, ``flow_t`` or ``graphnav_lcm.flow_t``."""

from __future__ import annotations

from collections.abc import Mapping

import graphnav_lcm

from graphnav.core.codec.known_types import message_classes, type_named
from graphnav.core.codec.layout import lcm_name
from graphnav.core.errors import UserError, did_you_mean

SHIPPED: tuple[type, ...] = tuple(found for found in vars(graphnav_lcm).values() if hasattr(found, "__typenames__"))
"""The types of ``lcmtypes/``, by name."""


def find_type(name: str, more: Mapping[str, type] | None = None) -> type:
    """Return the lcm-gen class of the LCM type or message class ``name``; shipped types come first.

    ``more``: further types by their LCM names, such as those of adapters.

    Raises
    ------
    UserError
        There is no such type; the hint names the nearest.
    """
    named: dict[str, type] = dict(more or {})
    for lcm_class in (*(message.lcm_class for message in message_classes()), *SHIPPED):
        named[lcm_name(lcm_class)] = lcm_class
    short = {full.rpartition(".")[2]: lcm_class for full, lcm_class in named.items()}
    short |= {message.__name__: message.lcm_class for message in reversed(list(message_classes()))}
    found = named.get(name) or short.get(name) or type_named(name)
    if found is None:
        hint = did_you_mean(name, {*named, *short}) or (
            "'graphnav types' lists the shipped types; for others write package.type_t and install the package"
        )
        raise UserError.of(f"there is no LCM type '{name}'", hint)
    return found
