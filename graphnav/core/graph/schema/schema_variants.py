"""Variants of the JSON Schema of graphs: for a graph that extends another one, or that brings plugins."""

from __future__ import annotations

from graphnav.core.spec import Schema

FAMILY_STAGE = r"^[a-z][a-z0-9_]*\.[a-z][a-z0-9_]*$"
_NULL: Schema = {"type": "null"}
_CONDITIONS = ("required", "allOf", "anyOf", "dependentSchemas")
"""Keywords that may make a key of a mapping required."""
_KEPT = ("about", "extends", "plugins", "run")
"""Keys that mean the same where a graph extends another."""


def by_keys(graph: Schema) -> Schema:
    """Return the schema of all graphs, given that of one that neither extends another nor brings plugins.

    Stages of plugins are not known; what a graph leaves out may be in the one that it extends, and null removes.
    """
    with_plugins = {"if": {"required": ["plugins"]}, "then": _stages_as(graph, "plugin_stage"), "else": graph}
    return {"if": {"required": ["extends"]}, "then": _extending(graph), "else": with_plugins}


def stage_variants(stage: Schema) -> dict[str, Schema]:
    """Return the definitions of stages that `by_keys` refers to, given that of a stage of the catalog."""
    use = {"type": "string", "pattern": FAMILY_STAGE, "description": "family.stage"}
    plugin_stage = {**stage, "properties": {**stage["properties"], "use": use}}
    words = {key: word for key, word in plugin_stage["properties"].items() if key != "use"}
    changed = {**_loose({**plugin_stage, "properties": words}), "type": ["object", "null"]}
    changed["properties"] = {"use": use, **changed["properties"]}
    return {"plugin_stage": plugin_stage, "extending_stage": changed}


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
    if isinstance(schema.get("additionalProperties"), dict):
        found["additionalProperties"] = {"anyOf": [_NULL, _loose(schema["additionalProperties"])]}
    return found
