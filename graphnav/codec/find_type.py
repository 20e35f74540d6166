"""Find the LCM type that a person names: ``Flow``, ``flow_t`` or ``graphnav_lcm.flow_t``."""

from __future__ import annotations

from collections.abc import Mapping

import graphnav_lcm

from graphnav.codec.known import message_classes, type_named
from graphnav.codec.layout import lcm_name
from graphnav.errors import UserError, did_you_mean

SHIPPED: tuple[type, ...] = tuple(found for found in vars(graphnav_lcm).values() if hasattr(found, "__typenames__"))
"""The types of ``lcmtypes/``, by name."""


def find_type(name: str, more: Mapping[str, type] | None = None) -> type:
    """Return the lcm-gen class that is called ``name``, or whose message is; the types that ship come first.

    ``more``: further types by the name that they have in LCM, above all those of adapters.

    Raises
    ------
    UserError
        There is none; the hint names the nearest.
    """
    named: dict[str, type] = dict(more or {})
    for lcm_class in (*(message.lcm_class for message in message_classes()), *SHIPPED):
        named[lcm_name(lcm_class)] = lcm_class
    short = {full.rpartition(".")[2]: lcm_class for full, lcm_class in named.items()}
    short |= {message.__name__: message.lcm_class for message in reversed(list(message_classes()))}
    found = named.get(name) or short.get(name) or type_named(name)
    if found is None:
        hint = did_you_mean(name, {*named, *short}) or (
            "'graphnav types' lists what ships; of another package write package.type_t, and install what lcm-gen made"
        )
        raise UserError.of(f"there is no LCM type '{name}'", hint)
    return found
