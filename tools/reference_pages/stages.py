"""The pages of the stages that ship: ports, parameters, metrics, and what each one says of itself."""

from __future__ import annotations

import json
from typing import Any

from graphnav.core.catalog import Catalog
from graphnav.core.spec import write_value
from graphnav.core.stage import describe, summary_of
from reference_pages.markdown import bullets, code, docstring, page, sentence, titled_bullets

CATALOG = Catalog()
FAMILIES = tuple(family for family in CATALOG.families() if CATALOG.names(family))
_KINDS = {"source": "a source", "stage": "a stage"}


def stages_page() -> str:
    """Return the page that lists all stages."""
    intro = (
        "What a graph may `use`, by family. Each family has a page with ports, parameters and sources. "
        "`graphnav stages plane.ica` prints the same in a terminal, for stages of your own, too."
    )
    return page("Stages", intro, *(_listed(family) for family in FAMILIES))


def family_page(family: str) -> str:
    """Return the page of a family."""
    sections = (_section(f"{family}.{name}") for name in CATALOG.names(family))
    return page(f"Stages: {family}", *sections)


def _listed(family: str) -> str:
    names = (f"{family}.{name}" for name in CATALOG.names(family))
    lines = (f"[{use}](stages/{family}.md#{use.replace('.', '')}): {_first_line(use)}" for use in names)
    return f"## {family}\n\n{bullets(lines)}"


def _first_line(use: str) -> str:
    return docstring(summary_of(CATALOG.stage(use)))


def _section(use: str) -> str:
    cls = CATALOG.stage(use)
    said: dict[str, Any] = describe(use, cls, CATALOG.origin(use))
    kind = sentence(_KINDS[said["kind"]], f"role: {cls.role}", "a guard" if cls.is_guard else "")
    return "\n\n".join(
        part
        for part in (
            f"## {use}",
            f"*{kind[0].upper()}{kind[1:]}.*",
            docstring(said["doc"]),
            sentence("Its ports are those that its parameters name: " + ", ".join(map(code, said["ports_from"])))
            if said["ports_from"]
            else "",
            titled_bullets("Inputs", [_input(port) for port in said["inputs"]]),
            titled_bullets("Outputs", [f"`{port['name']}`: {_message(port)}" for port in said["outputs"]]),
            titled_bullets("Parameters", [_param(param) for param in said["parameters"]]),
            titled_bullets("Metrics", [_metric(metric) for metric in said["metrics"]]),
        )
        if part
    )


def _input(port: dict[str, Any]) -> str:
    how = "sampled when something else fires the stage" if port["latest"] else "fires the stage"
    if port["since"]:
        how = "everything since the last firing"
    return f"`{port['name']}`: {sentence(_message(port), how, 'may stay unwired' if port['open'] else '')}"


def _message(port: dict[str, Any]) -> str:
    return f"[{port['type']}](../messages.md#{port['type'].lower()})"


def _param(param: dict[str, Any]) -> str:
    kind = sentence(_type(param["type"]), param["bounds"] and code(param["bounds"]), param["unit"])
    default = "required" if param["required"] else f"default {code(_value(param['default']))}"
    return f"`{param['name']}` ({kind}; {default}): {param['doc']}"


def _metric(metric: dict[str, Any]) -> str:
    better = "" if metric["better"] == "neither" else f"{metric['better']} is better"
    failed = {"measured": "", "undefined": "only of drives that arrive"}
    if_failed = failed.get(metric["if_failed"], f"{metric['if_failed']} if the drive failed")
    matters = f"differences matter from {metric['min_difference']:g}" if metric["min_difference"] else ""
    kind = sentence(metric["unit"], better, if_failed, matters)
    return f"`{metric['name']}`{f' ({kind})' if kind else ''}: {docstring(metric['doc'])}"


def _type(text: str) -> str:
    return text.replace("[", "\\[")


def _value(value: Any) -> str:
    return json.dumps(value) if value == "" else write_value(value)
