"""One-file plugins whose import, hooks and declarations misbehave."""

from __future__ import annotations

_PLUGIN = """
from attacks.zoo_stages import *
FAMILY = "strange"
class Still(Stage):
    def step(self, twist: Twist) -> None: ...
{}
"""
HOOKS = {
    "import": "misbehave({!r})",
    "attribute": "del FAMILY\ndef __getattr__(name):\n    misbehave({!r})",
    "graphnav_stages": "@hookimpl\ndef graphnav_stages():\n    misbehave({!r})",
    "declaration": (
        "class Bad(type(Still)):\n    role = property(lambda cls: misbehave({!r}))\n"
        "@hookimpl\ndef graphnav_stages():\n    return [Bad('Odd', (Still,), {{}})]"
    ),
    "graphnav_adapters": "@hookimpl\ndef graphnav_adapters():\n    misbehave({!r})",
    "graphnav_file_formats": "@hookimpl\ndef graphnav_file_formats():\n    misbehave({!r})",
}
_INTRUDER = "misbehave({0!r})\n@hookimpl\ndef graphnav_stages():\n    misbehave({0!r})\n    return [Still]"


def plugin_text(hook: str, kind: str) -> str:
    """Return the source of a plugin that misbehaves in a hook, in a way of the zoo."""
    return _PLUGIN.format(HOOKS[hook].format(kind))


def intruding_plugin_text(kind: str) -> str:
    """Return the source of a plugin that does what concerns the entire process while it is loaded."""
    return _PLUGIN.format(_INTRUDER.format(kind))
