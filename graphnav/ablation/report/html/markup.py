"""Elements of HTML; the only place that escapes text."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape

Html = str
"""Text that is markup: everything in it that people wrote is escaped."""


def esc(text: object) -> Html:
    """Return a text that shows as it is."""
    return escape(str(text), quote=True)


def tag(name: str, *children: Html, **attributes: object) -> Html:
    """Return an element with children that are HTML; a trailing underscore spares Python's words: ``class_``.

    An underscore within an attribute's name is a dash.
    """
    written = "".join(f' {key.rstrip("_").replace("_", "-")}="{esc(value)}"' for key, value in attributes.items())
    return f"<{name}{written}>{''.join(children)}</{name}>"


def listed(items: Iterable[Html], **attributes: object) -> Html:
    """Return a list without order; nothing for no items."""
    found = [tag("li", item) for item in items]
    return tag("ul", *found, **attributes) if found else ""


def table(head: Sequence[Html], rows: Iterable[Html], **attributes: object) -> Html:
    """Return a table in a box of its own, in which it scrolls where the page is too narrow."""
    header = tag("thead", tag("tr", *(tag("th", cell, scope="col") for cell in head)))
    return tag("div", tag("table", header, tag("tbody", *rows), **attributes), class_="scroll", tabindex=0)


def details(summary: Html, *body: Html, **attributes: object) -> Html:
    """Return what shows when a reader opens it."""
    return tag("details", tag("summary", summary), *body, **attributes)


def section(name: str, title: str, *body: Html) -> Html:
    """Return a part of the page that ``#name`` finds; nothing where its body is empty."""
    return tag("section", tag("h2", esc(title)), *body, id=name) if any(body) else ""
