"""The pages of files that are declared: maps, studies, and what a plugin reads."""

from __future__ import annotations

from graphnav.core.catalog import Catalog
from graphnav.core.spec import plugin_formats
from graphnav.studies.ablation.study import STUDY


def format_page(name: str) -> str:
    """Return the page of a kind of file, by the name that ``graphnav schema --of`` takes."""
    formats = {STUDY.name: STUDY, **plugin_formats(Catalog())}
    return formats[name].reference()
