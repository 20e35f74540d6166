"""The generated pages of the reference: one function a page, which returns its Markdown."""

from collections.abc import Callable, Mapping
from functools import partial

from reference_pages.commands import commands_page
from reference_pages.doors import architecture_page
from reference_pages.formats import format_page
from reference_pages.graphs import graphs_page
from reference_pages.messages import messages_page
from reference_pages.python import python_page
from reference_pages.stages import FAMILIES, family_page, stages_page

PAGES: Mapping[str, Callable[[], str]] = {
    "stages.md": stages_page,
    **{f"stages/{family}.md": partial(family_page, family) for family in FAMILIES},
    "graphs.md": graphs_page,
    "maps.md": partial(format_page, "map"),
    "studies.md": partial(format_page, "study"),
    "messages.md": messages_page,
    "commands.md": commands_page,
    "python.md": python_page,
    "../../ARCHITECTURE.md": architecture_page,
}
"""By path in ``docs/reference``."""
