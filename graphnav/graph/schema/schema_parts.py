"""The parts that all of the JSON Schema of graphs is made of."""

from __future__ import annotations

from typing import Any

from graphnav.spec.spec import STAGE_NAME

Schema = dict[str, Any]

PORT = rf"^{STAGE_NAME.pattern}\.{STAGE_NAME.pattern}$"
"""``stage.port``"""
CHANNEL = r"^(?!graphnav\.)[!-~]{1,63}$"
"""An LCM channel."""


def object_schema(properties: Schema, required: list[str] | None = None) -> Schema:
    """Return the schema of a mapping with no other keys than ``properties``."""
    schema: Schema = {"type": "object", "properties": properties, "additionalProperties": False}
    return {**schema, "required": required} if required else schema
