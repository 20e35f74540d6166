"""LCM types as source text in LCM's definition language."""

from __future__ import annotations

from collections.abc import Iterable

from graphnav.core.codec.layout import fields_of, lcm_name


def lcm_text_of(lcm_classes: Iterable[type]) -> str:
    """Return the definitions of the types and of all that are nested in them, each once, sorted by name.

    lcm-gen generates types with the same fingerprints from it. Comments and constants are left out: lcm-gen drops the
    former, and neither is on the wire.
    """
    found: dict[str, type] = {}
    waiting = list(lcm_classes)
    while waiting:
        lcm_class = waiting.pop()
        if found.setdefault(lcm_name(lcm_class), lcm_class) is lcm_class:
            nested = [field.struct for field in fields_of(lcm_class) if field.struct is not None]
            waiting += [struct for struct in nested if lcm_name(struct) not in found]
    return "\n".join(definition_of(found[name]) for name in sorted(found))


def definition_of(lcm_class: type) -> str:
    """Return the definition of one type, without those that are nested in it."""
    package = lcm_name(lcm_class).rpartition(".")[0]
    lines = [
        f"    {field.primitive} {field.name}{''.join(f'[{dim}]' for dim in field.dims)};"
        for field in fields_of(lcm_class)
    ]
    head = [f"package {package};", ""] if package else []
    return "\n".join([*head, f"struct {lcm_class.__name__}", "{", *lines, "}", ""])
