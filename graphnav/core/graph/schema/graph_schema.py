"""The JSON Schema (draft 2020-12) of graphs of the installed stages."""

from __future__ import annotations

from graphnav.core.catalog import Catalog
from graphnav.core.graph.schema.outside_schema import inputs_schema, outputs_schema, queues_schema
from graphnav.core.graph.schema.schema_parts import CHANNEL, PORT
from graphnav.core.graph.schema.schema_variants import by_keys, stage_variants
from graphnav.core.spec import DIALECT, RECORD_KEYS, RunOptions, Schema, object_schema, param_schema
from graphnav.core.spec.outside import MAX_EVERY_MS, MIN_EVERY_MS
from graphnav.core.spec.spec import RESERVED_STAGES, STAGE_NAME
from graphnav.core.stage import Stage, params_of, ports_of, summary_of

_REF = rf"^{STAGE_NAME.pattern}(\.{STAGE_NAME.pattern})?$"


def graph_schema(catalog: Catalog) -> Schema:
    """Return the schema of graphs whose stages are those of the catalog, which are all imported.

    It refuses what a schema can: words, stages, parameters, bounds and ports that do not exist or are missing. What
    wires mean (types, loops) only the check of the graph can tell.

    Raises
    ------
    CatalogError
        A package of a family cannot be used.
    """
    uses = {f"{family}.{name}": None for family in catalog.families() for name in catalog.names(family)}
    classes = {use: catalog.stage(use) for use in uses}
    stage = _stage(list(classes))
    return {
        "$schema": DIALECT,
        "title": "A graph of graphnav",
        **by_keys(_graph()),
        "$defs": {"stage": stage, **stage_variants(stage), **{use: _use(cls) for use, cls in classes.items()}},
    }


def _graph() -> Schema:
    return object_schema(
        {
            "about": {"type": "string", "description": "what the graph does, in a sentence"},
            "extends": {
                "anyOf": [
                    {"type": "string", "minLength": 1},
                    {"type": "array", "minItems": 1, "uniqueItems": True, "items": {"type": "string", "minLength": 1}},
                ],
                "description": "a graph, beside this one or one that ships, whose values those of this one override; "
                "or a list of them, in which each one overrides those before it",
            },
            "plugins": {
                "type": ["array", "null"],
                "items": {"type": "string", "minLength": 1},
                "description": "files with stages, relative to this one",
            },
            "run": _optional(_run()),
            "stages": {
                "type": "object",
                "minProperties": 1,
                "propertyNames": {"pattern": f"^{STAGE_NAME.pattern}$", "not": {"enum": list(RESERVED_STAGES)}},
                "additionalProperties": {"$ref": "#/$defs/stage"},
            },
            "channels": {
                "type": ["object", "null"],
                "description": "LCM channels with another name than stage.port",
                "propertyNames": {"pattern": PORT},
                "additionalProperties": {"type": "string", "pattern": CHANNEL},
            },
            "inputs": inputs_schema(),
            "outputs": outputs_schema(),
            "queues": queues_schema(),
        },
        required=["stages"],
    )


def _run() -> dict[str, Schema]:
    declared = {name: param_schema(param) for name, param in params_of(RunOptions).items()}
    record = object_schema({key: declared[name] for key, name in RECORD_KEYS.items()}, [])
    both = {"anyOf": [declared["record"], record], "description": declared["record"].get("description", "")}
    return {
        name: both if name == "record" else schema
        for name, schema in declared.items()
        if name == "record" or name not in RECORD_KEYS.values()
    }


def _stage(uses: list[str]) -> Schema:
    words: Schema = {
        "use": {"enum": uses, "description": "family.stage"},
        "with": {"type": ["object", "null"], "description": "parameters"},
        "in": {"type": ["object", "null"], "description": "what each input reads: stage.port"},
        "every_ms": {
            "type": "number",
            "minimum": MIN_EVERY_MS,
            "maximum": MAX_EVERY_MS,
            "description": "live, the stage also fires this often; lockstep does not use it",
        },
        "deadline_ms": {
            "type": "number",
            "exclusiveMinimum": 0,
            "description": "a step that ends later than this after its newest input is counted as missed",
        },
    }
    which = [
        {"if": {"properties": {"use": {"const": use}}, "required": ["use"]}, "then": {"$ref": f"#/$defs/{use}"}}
        for use in uses
    ]
    return {**object_schema(words, required=["use"]), "allOf": which}


def _use(cls: type[Stage]) -> Schema:
    params, inputs = params_of(cls), ports_of(cls).inputs
    needed = [name for name, param in params.items() if param.required]
    plain = [port.name for port in inputs if not port.may_be_open]
    wires = {
        port.name: {"type": "string", "pattern": _REF, "description": f"a channel of {port.message.__name__}"}
        for port in inputs
    }
    return {
        "description": summary_of(cls),
        "properties": {
            "with": _optional({name: param_schema(param) for name, param in params.items()}, needed),
            "in": _optional(wires, plain),
        },
        "required": [word for word, names in (("with", needed), ("in", plain)) if names],
    }


def _optional(properties: Schema, required: list[str] | None = None) -> Schema:
    """Return the schema of a mapping that may be empty (null) if nothing in it is required."""
    schema = object_schema(properties, required or [])
    return schema if required else {**schema, "type": ["object", "null"]}
