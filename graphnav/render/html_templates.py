"""Render templates of HTML and SVG; every value that they show is escaped."""

from __future__ import annotations

from functools import cache

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup


def rendered(package: str, template: str, /, **values: object) -> Markup:
    """Return ``templates/<template>`` of a package with ``values`` filled in, as the only kind of markup that exists.

    Strings are escaped; what this function returned before is inserted as it is. White space at both ends is removed,
    so that a template that shows nothing returns an empty string. Raises UndefinedError for a value that the template
    names and that is not given.
    """
    text = _environment(package).get_template(template).render(values)
    return Markup(text.strip())  # noqa: S704 - made by a template that escapes every value


@cache
def _environment(package: str) -> Environment:
    environment = Environment(
        loader=PackageLoader(package),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["px"] = _pixels
    return environment


def _pixels(value: float) -> str:
    """Return a coordinate of a drawing, to a tenth of a pixel."""
    return f"{value:.1f}"
