"""The JSON Schema of what comes in from other programs, what leaves, and what waits in between."""

from __future__ import annotations

from graphnav.core.graph.schema.schema_parts import CHANNEL, PORT
from graphnav.core.spec import Schema, object_schema
from graphnav.core.spec.outside import MAX_INPUT_AGE_S, MAX_STOP_AFTER_S, STOP_AFTER_S

_TYPE = r"^[A-Za-z_][A-Za-z0-9_]*(\.[A-Za-z_][A-Za-z0-9_]*)*$"


def inputs_schema() -> Schema:
    """Return the schema of ``inputs``."""
    words = {
        "channel": {
            "type": "string",
            "minLength": 1,
            "description": "the LCM channel that another program writes; of a log, the channel in it",
        },
        "log": {"type": "string", "minLength": 1, "description": "a log that is played at its stamps"},
        "type": _lcm_type("the LCM type on the wire: package.type_t"),
        "max_age_s": _seconds(
            "older than this, the input counts as lost; default: a few of its periods", MAX_INPUT_AGE_S
        ),
    }
    live = {"properties": {"channel": {"pattern": CHANNEL}}, "required": ["channel"]}
    source = {"anyOf": [{"required": ["log"]}, live]}
    return {
        "type": ["object", "null"],
        "description": "channels that other programs write, which makes the graph live",
        "propertyNames": {"pattern": PORT},
        "additionalProperties": {**object_schema(words, required=["type"]), **source},
    }


def outputs_schema() -> Schema:
    """Return the schema of ``outputs``."""
    words = {
        "channel": {"type": "string", "pattern": CHANNEL, "description": "the LCM channel on which it leaves"},
        "type": _lcm_type("the LCM type on the wire: package.type_t; default: that of the message"),
        "motor": {
            "type": "boolean",
            "default": False,
            "description": "whether it moves something: stops follow it; a Twist has to say",
        },
        "max_age_s": {
            **_seconds("silence of a motor channel that is answered by stops", MAX_STOP_AFTER_S),
            "default": STOP_AFTER_S,
        },
        "stop": {"type": "object", "minProperties": 1, "description": "the LCM fields of the stop message"},
    }
    motor = {"properties": {"motor": {"const": True}}, "required": ["motor"]}
    return {
        "type": ["object", "null"],
        "description": "channels that leave a live graph, by stage.port; lockstep does not use it",
        "propertyNames": {"pattern": PORT},
        "additionalProperties": {**object_schema(words, required=["channel"]), "dependentSchemas": {"stop": motor}},
    }


def queues_schema() -> Schema:
    """Return the schema of ``queues``."""
    keep = {"anyOf": [{"const": "all"}, {"type": "integer", "minimum": 1}]}
    return {
        "type": ["object", "null"],
        "description": "inputs of stages of which every complete set fires, live, and how many messages wait there",
        "propertyNames": {"pattern": PORT},
        "additionalProperties": object_schema({"keep": keep}, required=["keep"]),
    }


def _lcm_type(description: str) -> Schema:
    return {"type": "string", "pattern": _TYPE, "description": description}


def _seconds(description: str, maximum: float) -> Schema:
    return {"type": "number", "exclusiveMinimum": 0, "maximum": maximum, "description": description}
