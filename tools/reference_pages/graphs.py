"""The page of graph files: their keys, from the JSON Schema, and the graphs that ship."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from graphnav.core.catalog import Catalog
from graphnav.core.graph import graph_schema, load_graph, shipped_graphs
from graphnav.core.spec import write_value
from reference_pages.markdown import bullets, code, page, sentence

Schema = Mapping[str, Any]

_INTRO = """\
A graph is a YAML file (YAML 1.2: `1e-3` is a number, `on` and `no` are strings). `graphnav check FILE` reports
everything that is wrong with one, with line and column; `graphnav schema > graph.schema.json` prints the JSON
Schema, with which editors complete and check a graph while you write it.

```yaml
about: A camera that looks at the floor.
run: {until_s: 60, seed: 7}
stages:
  robot: {use: world.pymunk, with: {map: maps/corridor_ccw.yaml}}
  flow:  {use: flow.lucas_kanade, in: {image: robot.image}}
```

A channel is called `stage.port`; `stage` alone is enough where the stage has one output. Paths are relative to the
file that contains them."""
_MORE = {
    "extends": "Mappings are merged key by key; anything else is replaced. `null` removes a stage, a wire or an entry "
    "of a section. A stage whose `use` changes is swapped as `--set` would swap it: wires of ports with the same name "
    "and type stay. Of a list each graph overrides those before it; a file that several of them extend is read once, "
    "where it comes first. `parts/NAME` that ships, or a file of yours, may contain some stages only.",
    "stages": "Stages by name (lower-case letters, digits and `_`, beginning with a letter). Order matters in one way: "
    "sources that are due at the same time fire in the order of the file.",
    "run": "How the graph runs, unless the command line says otherwise.",
}
_PLACEHOLDER = {"stages": "NAME", "channels": "STAGE.PORT"}


def graphs_page() -> str:
    """Return the page."""
    schema = graph_schema(Catalog())
    graph = schema["else"]["else"]
    parts = [_key(key, value, schema, key in graph["required"]) for key, value in graph["properties"].items()]
    shipped = "## Graphs that ship\n\nRun them by name: `graphnav run corridor_ccw`. The files are in "
    shipped += "[graphs/graphnav_graphs](../../graphs/graphnav_graphs/corridor_ccw.yaml)."
    return page("Graphs", _INTRO, "## Keys of a graph file", *parts, shipped, *map(_shipped, shipped_graphs()))


def _key(key: str, value: Schema, schema: Schema, is_required: bool) -> str:  # noqa: FBT001
    title = f"### {key}"
    about = " ".join(f"{said}." for said in ("Required" if is_required else "", _description(value)) if said)
    entries = list(_entries(_PLACEHOLDER.get(key, "STAGE.PORT"), value, schema))
    return "\n\n".join(part for part in (title, about, _MORE.get(key, ""), bullets(entries)) if part)


def _entries(placeholder: str, value: Schema, schema: Schema) -> Iterator[str]:
    """Yield a line for each key of a section, or of each entry of a section whose entries have names."""
    for name, inner in value.get("properties", {}).items():
        yield _line(name, inner, value)
    each = value.get("additionalProperties")
    if isinstance(each, dict):
        each = schema["$defs"]["stage"] if "$ref" in each else each
        for name, inner in each.get("properties", {}).items():
            yield _line(f"{placeholder}.{name}", inner, each)
        if "properties" not in each:
            yield _line(placeholder, each, {})


def _line(name: str, value: Schema, parent: Schema) -> str:
    is_required = name.rpartition(".")[2] in parent.get("required", ())
    default = f"default {code(write_value(value['default']))}" if "default" in value else ""
    kind = sentence(_type(value), _bounds(value), "required" if is_required else default)
    return f"`{name}` ({kind})" + (f": {_description(value)}" if "description" in value else "")


def _description(value: Schema) -> str:
    said = str(value.get("description", ""))
    return said[:1].upper() + said[1:] if said else ""


def _type(value: Schema) -> str:
    if "enum" in value:
        return "family.stage" if len(value["enum"]) > 9 else " or ".join(code(str(one)) for one in value["enum"])
    if "const" in value:
        return code(str(value["const"]))
    if "anyOf" in value:
        return " or ".join(_type(one) for one in value["anyOf"])
    kinds = value["type"] if isinstance(value["type"], list) else [value["type"]]
    return " or ".join({"object": "mapping", "array": "list"}.get(kind, str(kind)) for kind in kinds)


def _bounds(value: Schema) -> str:
    signs = {"minimum": ">=", "exclusiveMinimum": ">", "maximum": "<=", "exclusiveMaximum": "<"}
    inner = [value, *value.get("anyOf", ())]
    found = (f"{sign} {one[word]:.12g}" for one in inner for word, sign in signs.items() if word in one)
    listed = " and ".join(found)
    return code(listed) if listed else ""


def _shipped(name: str) -> str:
    graph = load_graph(shipped_graphs()[name], Catalog())
    stages = (f"`{node.name}`: {code(node.use)}" for node in graph.nodes)
    return f"### {name}\n\n{graph.about}\n\n{bullets(stages)}"
