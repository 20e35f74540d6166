"""Templates of ``graphnav new-stage``: a working stage of a family, its test, and next steps that run as printed."""

from __future__ import annotations

import shlex
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path
from string import Template

from graphnav.core.graph import shipped_graphs
from graphnav.core.spec import RESERVED_STAGES, outline_of
from graphnav.develop.commands.stage_kinds import kind_of

_STAGE = Template('''"""$doc"""

$imports

FAMILY = "$family"


class $cls($base):
    """$doc"""

$params
$body

@hookimpl
def graphnav_stages() -> list[type[Stage]]:
    return [$cls]
''')

_TEST = Template('''"""Tests of $family.$name."""

from pathlib import Path
from typing import Any

${imports}from graphnav.core.catalog import Catalog
from graphnav.testing import check_stage

CATALOG = Catalog()
CATALOG.add_file(Path(__file__).with_name("$name.py"))
$cls: Any = CATALOG.stage("$family.$name")
${example}def test_keeps_the_contract_of_stages() -> None:
    check_stage($cls, $steps)


$test
''')
_TRY_S = 10
"""Duration of the printed run, simulated seconds: sources of noise never end by themselves."""
_MAX_NAME = 40
"""Longer stage names may result in channel names that LCM refuses."""


def stage_text(family: str, cls: str) -> str:
    """Return the source of a one-file plugin."""
    kind = kind_of(family)
    return _STAGE.substitute(
        family=family,
        cls=cls,
        doc=kind.doc,
        base=kind.base,
        imports=kind.imports,
        params=kind.params,
        body=kind.body,
    )


def test_text(family: str, name: str, cls: str) -> str:
    """Return the source of its test."""
    kind = kind_of(family)
    return _TEST.substitute(
        family=family,
        name=name,
        cls=cls,
        imports=f"{kind.test_imports}\n" if kind.test_imports else "",
        example=f"\n{kind.example.rstrip()}\n\n\n" if kind.example else "\n\n",
        steps=kind.steps,
        test=Template(kind.test).substitute(cls=cls).rstrip("\n"),
    )


def hints(family: str, name: str, stage_file: Path, test_file: Path) -> Iterator[str]:
    """Yield the next steps for a new stage: its files, how to test, run and use it."""
    plugin = shlex.quote(str(stage_file))
    yield f"{stage_file}: a working stage, {family}.{name}"
    needs = "" if find_spec("pytest") else " (it needs pytest: python -m pip install pytest)"
    yield f"{test_file}: its test{needs}; run it with: python -m pytest {shlex.quote(str(test_file))}"
    graph, target = _tried(family, name)
    yield f"Try it: graphnav run {graph} --plugin {plugin} --set {target}={family}.{name} --until {_TRY_S}"
    yield f"In a graph beside it: plugins: [{stage_file.name}], and a stage with use: {family}.{name}"


def _tried(family: str, name: str) -> tuple[str, str]:
    """Return the shipped graph in which to try a stage, and the ``--set`` target there."""
    kind = kind_of(family)
    if kind.swaps:
        return kind.graph, kind.swaps
    spec = outline_of(shipped_graphs()[kind.graph].read_bytes(), kind.graph)
    taken = {*spec.stages, *RESERVED_STAGES, "graphnav"}
    free = (called for called in (name, f"new_{name}", "new_stage") if called not in taken and len(called) <= _MAX_NAME)
    return kind.graph, f"{next(free)}+"
