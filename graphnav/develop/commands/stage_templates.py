"""Templates of ``graphnav new-stage``: a working stage of a family and its test."""

from __future__ import annotations

from string import Template

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
