"""Render templates of HTML and SVG; every value that they show is escaped."""

from __future__ import annotations

from functools import cache
from pathlib import Path

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from graphnav.core.errors import printable


def rendered(package: str, template: str, /, **values: object) -> Markup:
    """Return ``templates/<template>`` of a package with ``values`` filled in, as the only kind of markup that exists.

    Strings are escaped, and made `printable`; what this function returned before is inserted as it is. White space at
    both ends is removed, so that a template that shows nothing returns an empty string. Raises UndefinedError for a
    value that the template names and that is not given.
    """
    text = _environment(package).get_template(template).render(values)
    return Markup(text.strip())  # noqa: S704 - made by a template that escapes every value


@cache
def _environment(package: str) -> Environment:
    environment = Environment(
        loader=PackageLoader(package),
        autoescape=True,
        finalize=_printable,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["px"] = _pixels
    return environment


def _printable(value: object) -> object:
    """Return a value in which nothing is invisible or changes the order of the text."""
    if isinstance(value, Markup):
        return value
    return printable(str(value)) if isinstance(value, (str, Path)) else value


def _pixels(value: float) -> str:
    """Return a coordinate of a drawing, to a tenth of a pixel."""
    return f"{value:.1f}"
