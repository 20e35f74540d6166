"""Known LCM types, by name and by fingerprint; a type by any of its names."""

from __future__ import annotations

import importlib
import importlib.util
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import NamedTuple

import graphnav_lcm

from graphnav.core.codec.layout import fingerprint, hide_prefix, lcm_name
from graphnav.core.errors import UserError, did_you_mean
from graphnav.core.messages import Message, snake_case

_added: dict[str, type] = {}
"""Types without a message class, by their LCM names; filled by imports, as subclasses are."""
_n_added = 0
SHIPPED: tuple[type, ...] = tuple(found for found in vars(graphnav_lcm).values() if hasattr(found, "__typenames__"))
"""The types of ``lcmtypes/``, by name."""


class _ByFingerprint(NamedTuple):
    """The known types by fingerprint, and the numbers of message classes and added types at that time."""

    age: tuple[int, int]
    types: Mapping[bytes, type]


_by_fingerprint = _ByFingerprint((-1, -1), {})


def add_type(name: str, lcm_class: type) -> None:
    """Register an lcm-gen class as ``name`` (``package.type_t``), even if its package is inside another one."""
    global _n_added  # noqa: PLW0603, the registry is per process
    _added[name] = lcm_class
    _n_added += 1
    if (full := lcm_name(lcm_class)).endswith(f".{name}"):
        hide_prefix(full.removesuffix(name))


def message_classes() -> Iterator[type[Message]]:
    """Yield every imported message class, shipped ones first.

    A class whose declaration was refused remains among Python's subclasses for a while; it has no LCM type.
    """
    waiting: list[type[Message]] = Message.__subclasses__()
    while waiting:
        found = waiting.pop(0)
        if hasattr(found, "lcm_class"):
            yield found
        waiting += found.__subclasses__()


def messages_by_name() -> dict[str, type[Message]]:
    """Return the imported message classes by their names as ports have them, ``local_map``; the first of a name."""
    found: dict[str, type[Message]] = {}
    for message in message_classes():
        found.setdefault(snake_case(message.__name__), message)
    return found


def message_class_of(lcm_class: type) -> type[Message] | None:
    """Return the imported message class that wraps an LCM type, now or in older logs, None if there is none."""
    return next(
        (found for found in message_classes() if lcm_class in (found.lcm_class, *found.former_lcm_classes)), None
    )


def message_types() -> dict[str, type[Message]]:
    """Return the imported message classes by the names of their LCM types."""
    return {lcm_name(found.lcm_class): found for found in reversed(list(message_classes()))}


def type_named(name: str) -> type | None:
    """Return the lcm-gen class of ``package.type_t``, None if it is not installed; `type_of` then knows it too."""
    for found in message_classes():
        if lcm_name(found.lcm_class) == name:
            return found.lcm_class
    if name in _added:
        return _added[name]
    package, _, short = name.rpartition(".")
    if not all(part.isidentifier() for part in name.split(".")) or not _is_lcm_module(package, short):
        return None
    lcm_class = getattr(importlib.import_module(package), short, None)
    if not isinstance(lcm_class, type) or not hasattr(lcm_class, "__typenames__"):
        return None
    if hasattr(lcm_class, "_get_packed_fingerprint"):  # else it has the name of one, and lcm-gen did not make it
        add_type(name, lcm_class)
    return lcm_class


def _is_lcm_module(package: str, short: str) -> bool:
    """Whether lcm-gen may have generated ``package``: names from logs and networks must not import anything else."""
    top, *inner = package.split(".")
    try:
        spec = importlib.util.find_spec(top) if top else None
    except (ModuleNotFoundError, ValueError):
        return False
    folders = (spec.submodule_search_locations if spec else None) or ()
    return short.endswith("_t") and any(Path(folder, *inner, f"{short}.py").is_file() for folder in folders)


def known_types() -> list[type]:
    """Return the shipped and the imported lcm-gen classes, each once."""
    wrapped = [found.lcm_class for found in message_classes()]
    return list(dict.fromkeys((*SHIPPED, *wrapped, *_added.values())))


def type_of(data: bytes) -> type | None:
    """Return the known lcm-gen class whose fingerprint the bytes begin with, or None."""
    global _by_fingerprint  # noqa: PLW0603
    known, age = _by_fingerprint, (Message.n_classes, _n_added)
    if known.age != age:
        types = {fingerprint(lcm_class): lcm_class for lcm_class in reversed(known_types())}
        known = _by_fingerprint = _ByFingerprint(age, types)
    return known.types.get(data[:8])


def find_type(name: str, more: Mapping[str, type] | None = None) -> type:
    """Return the lcm-gen class of the LCM type or message class ``name``; shipped types come first.

    ``more``: further types by their LCM names, such as those of adapters.

    Raises
    ------
    UserError
        The type does not exist; the hint names a similar one.
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
