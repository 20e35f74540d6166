"""The JSON Schema (draft 2020-12) of graphs of the installed stages: the declared keys, with what the catalog knows."""

from __future__ import annotations

from typing import Any

from graphnav.core.catalog import Catalog
from graphnav.core.spec import (
    DIALECT,
    RESERVED_STAGES,
    STAGE_NAME,
    GraphKeys,
    Schema,
    object_schema,
    param_schema,
    record_object,
)
from graphnav.core.stage import Stage, params_of, ports_of, summary_of

_REF = rf"^{STAGE_NAME}(\.{STAGE_NAME})?$"
_FAMILY_STAGE = rf"^{STAGE_NAME}\.{STAGE_NAME}$"
_NULL: Schema = {"type": "null"}
_CONDITIONS = ("required", "allOf", "anyOf", "dependentSchemas")
"""Keywords that may make a key of a mapping required."""
_KEPT = ("about", "extends", "plugins", "run")
"""Keys that mean the same where a graph extends another."""


def graph_schema(catalog: Catalog) -> Schema:
    """Return the schema of graphs whose stages are those of the catalog, which are all imported.

    It refuses what a schema can: words, stages, parameters, bounds and ports that do not exist or are missing. What
    wires mean (types, loops) only the check of the graph can tell. Stages of a graph with plugins are not known; what
    a graph that extends another leaves out may be in that one, and null removes.

    Raises
    ------
    CatalogError
        A package of a family cannot be used.
    """
    uses = {f"{family}.{name}": None for family in catalog.families() for name in catalog.names(family)}
    classes = {use: catalog.stage(use) for use in uses}
    graph, stage = _declared()
    with_plugins = {"if": {"required": ["plugins"]}, "then": _stages_as(graph, "plugin_stage"), "else": graph}
    return {
        "$schema": DIALECT,
        "title": "A graph of graphnav",
        "if": {"required": ["extends"]},
        "then": _extending(graph),
        "else": with_plugins,
        "$defs": {
            **_stages(stage, list(classes)),
            **{use: _use(cls) for use, cls in classes.items()},
        },
    }


def _declared() -> tuple[Schema, Schema]:
    """Return the schemas of a graph and of a stage as they are declared, with all records written out."""
    found: dict[str, Schema] = {}
    graph = _written_out(record_object(GraphKeys, found), found)
    graph["properties"]["stages"]["propertyNames"]["not"] = {"enum": list(RESERVED_STAGES)}
    stage = graph["properties"]["stages"]["additionalProperties"]
    return _stages_as(graph, "stage"), stage


def _written_out(schema: Any, found: dict[str, Schema]) -> Any:
    """Return a schema in which no reference is left to those that are ``found`` by name."""
    if isinstance(schema, list):
        return [_written_out(one, found) for one in schema]
    if not isinstance(schema, dict):
        return schema
    if "$ref" in schema:
        inner = _written_out(found[schema["$ref"].rpartition("/")[2]], found)
        return {**inner, **{word: value for word, value in schema.items() if word != "$ref"}}
    return {word: _written_out(value, found) for word, value in schema.items()}


def _stages(stage: Schema, uses: list[str]) -> dict[str, Schema]:
    """Return the definitions of a stage: of the catalog, of one that may be a plugin's, of a graph that extends."""
    which = [
        {"if": {"properties": {"use": {"const": use}}, "required": ["use"]}, "then": {"$ref": f"#/$defs/{use}"}}
        for use in uses
    ]
    words = stage["properties"]
    known = {**words, "use": {"enum": uses, "description": words["use"]["description"]}}
    any_use = {**words, "use": {**words["use"], "pattern": _FAMILY_STAGE}}
    plugin_stage = {**stage, "properties": any_use, "allOf": which}
    changed = {**_loose(plugin_stage), "type": ["object", "null"]}
    changed["properties"]["use"] = any_use["use"]
    return {
        "stage": {**stage, "properties": known, "allOf": which},
        "plugin_stage": plugin_stage,
        "extending_stage": changed,
    }


def _use(cls: type[Stage]) -> Schema:
    params, inputs = params_of(cls), ports_of(cls).inputs
    needed = [name for name, param in params.items() if param.required]
    plain = [port.name for port in inputs if not port.may_be_open]
    wires = {
        port.name: {"type": "string", "pattern": _REF, "description": f"a channel of {port.message.__name__}"}
        for port in inputs
    }
    free: Schema = {"type": "object", "additionalProperties": {"type": "string", "pattern": _REF}}
    return {
        "description": summary_of(cls),
        "properties": {
            "with": _optional({name: param_schema(param) for name, param in params.items()}, needed),
            "in": free if cls.ports_from else _optional(wires, plain),
        },
        "required": [word for word, names in (("with", needed), ("in", plain)) if names],
    }


def _optional(properties: Schema, required: list[str]) -> Schema:
    """Return the schema of a mapping that may be empty (null) if nothing in it is required."""
    schema = object_schema(properties, required)
    return schema if required else {**schema, "type": ["object", "null"]}


def _stages_as(graph: Schema, name: str) -> Schema:
    stages = {**graph["properties"]["stages"], "additionalProperties": {"$ref": f"#/$defs/{name}"}}
    return {**graph, "properties": {**graph["properties"], "stages": stages}}


def _extending(graph: Schema) -> Schema:
    """Return the schema of a graph that extends another: everything may be left out, and sections take null."""
    properties = _stages_as(graph, "extending_stage")["properties"]
    stages = {key: word for key, word in properties["stages"].items() if key != "minProperties"}
    loose = {key: word if key in _KEPT else _loose(word) for key, word in properties.items() if key != "stages"}
    merged = {**loose, "stages": {**stages, "type": ["object", "null"]}}
    return {**{key: word for key, word in graph.items() if key != "required"}, "properties": merged}


def _loose(schema: Schema) -> Schema:
    """Return a mapping's schema in which nothing is required and null may be under every key."""
    found = dict(schema)
    if "properties" in schema:
        found = {key: word for key, word in schema.items() if key not in _CONDITIONS}
        found["properties"] = {key: {"anyOf": [_NULL, _loose(word)]} for key, word in schema["properties"].items()}
    elif "anyOf" in schema:
        found["anyOf"] = [_loose(member) for member in schema["anyOf"]]
    if schema.get("additionalProperties"):
        found["additionalProperties"] = {"anyOf": [_NULL, _loose(schema["additionalProperties"])]}
    return found
