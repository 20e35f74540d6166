"""No page shows a string as markup."""

from __future__ import annotations

import ast
from html import unescape
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from jinja2 import UndefinedError
from jinja2.nodes import Filter, ScopedEvalContextModifier
from markupsafe import Markup

import graphnav
from graphnav.core import html_templates
from graphnav.core.errors import printable

CORE = Path(graphnav.__file__).parent
TEMPLATES = sorted(path for path in CORE.rglob("templates/*") if path.suffix in {".html", ".svg"})


@given(about=st.text(), table=st.text())
def test_values_are_text(about: str, table: str) -> None:
    page = html_templates.rendered("graphnav.studies.api", "study.html", about=about, table=table, report="there")
    assert unescape(page).startswith(f"<p>{printable(about)}</p><pre>{printable(table)}</pre>")
    assert page.count("<") == 6


def test_rendered_templates_are_inserted_as_they_are() -> None:
    inner = html_templates.rendered("graphnav.studies.api", "study.html", about="<b>", table="", report="")
    outer = html_templates.rendered("graphnav.studies.api", "study.html", about=inner, table="", report="")
    assert isinstance(outer, Markup)
    assert outer.startswith("<p><p>&lt;b&gt;</p>")


def test_a_value_that_is_not_given_is_an_error() -> None:
    with pytest.raises(UndefinedError, match="table"):
        html_templates.rendered("graphnav.studies.api", "study.html", about="", report="")


@pytest.mark.parametrize("path", TEMPLATES, ids=lambda path: path.relative_to(CORE).as_posix())
def test_no_template_switches_escaping_off(path: Path) -> None:
    package = ".".join(("graphnav", *path.parent.parent.relative_to(CORE).parts))
    environment = html_templates._environment(package)
    tree = environment.parse(path.read_text(encoding="utf-8"))
    assert [node for node in tree.find_all(Filter) if node.name in {"safe", "forceescape"}] == []
    assert list(tree.find_all(ScopedEvalContextModifier)) == []


def test_only_the_engine_makes_markup() -> None:
    makers = {
        path.relative_to(CORE).as_posix()
        for path in CORE.rglob("*.py")
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.Call)
        if isinstance(node.func, ast.Name) and node.func.id == "Markup"
        if not (len(node.args) == 1 and isinstance(node.args[0], ast.Constant))
    }
    assert makers == {"core/html_templates.py"}
