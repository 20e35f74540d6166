"""Folders export what their ``__init__.pyi`` lists, on first use."""

from __future__ import annotations

import ast
import importlib
from pathlib import Path
from types import ModuleType

import pytest

import graphnav

PACKAGE = Path(graphnav.__file__).parent
STUBS = sorted(PACKAGE.rglob("__init__.pyi"))


@pytest.mark.parametrize("stub", STUBS, ids=lambda path: path.parent.name)
def test_every_name_is_exported(stub: Path) -> None:
    package = importlib.import_module(".".join(("graphnav", *stub.parent.relative_to(PACKAGE).parts)))
    listed = [
        name.asname or name.name
        for node in ast.walk(ast.parse(stub.read_text()))
        if isinstance(node, ast.ImportFrom)
        for name in node.names
    ]
    assert set(package.__all__) - {"__version__"} == set(listed) <= set(dir(package))
    twice = [*listed, *listed]  # the first use imports the module, which may then hide the name
    hidden = [name for name in twice if isinstance(getattr(package, name), ModuleType)]
    assert not hidden, "a module of the same name hides them: give it another one"


def test_an_unknown_name_raises_as_in_any_module() -> None:
    with pytest.raises(AttributeError, match="module 'graphnav' has no attribute 'nothing'"):
        getattr(graphnav, "nothing")  # noqa: B009 - mypy knows that there is none
    assert not hasattr(graphnav.core.machine, "nothing")
