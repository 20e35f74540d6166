"""Render the templates of the report."""

from __future__ import annotations

from markupsafe import Markup

from graphnav.core.render import html_templates


def rendered(template: str, /, **values: object) -> Markup:
    """Return ``templates/<template>`` with ``values`` filled in; strings are escaped."""
    return html_templates.rendered("graphnav.studies.ablation.report.html", template, **values)
