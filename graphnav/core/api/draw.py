"""Drawings of graphs, for notebooks, terminals and other programs."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from typing import TYPE_CHECKING

from graphnav.core.api.arguments import PathLike
from graphnav.core.api.load import loaded
from graphnav.core.api.parameters import Shared
from graphnav.core.catalog import Catalog
from graphnav.core.graph import Graph
from graphnav.core.parameters import documented
from graphnav.core.render import dot_of, mermaid_of, svg_of, text_of
from graphnav.core.trust import Trust

if TYPE_CHECKING:
    from rich.text import Text

_COLOURS = ("cyan", "magenta", "green", "yellow", "blue", "red", "bright_cyan", "bright_magenta", "bright_green")


@documented(*Shared.LOADED)
def draw(
    graph: PathLike | Graph,
    *,
    set: Mapping[str, object] | None = None,  # noqa: A002 - as --set
    plugins: Sequence[PathLike] = (),
    trust: bool = False,
) -> Drawing:
    """Return the drawing of a graph: a picture in a notebook, boxes in a terminal.

    Raises
    ------
    UserError
        All errors of the graph.
    """
    return Drawing(loaded(graph, set, plugins, Catalog(Trust(runs_all=trust))))


class Drawing:
    """A graph as ``text`` (boxes, for terminals), ``svg``, ``mermaid`` and ``dot``.

    A notebook shows the SVG; ``print`` and a prompt show the boxes, and rich's console shows them in colour.
    """

    def __init__(self, graph: Graph) -> None:
        self.graph = graph

    @cached_property
    def text(self) -> str:
        """Boxes and lines for a terminal."""
        return str(text_of(self.graph))

    @cached_property
    def svg(self) -> str:
        """An SVG picture."""
        return svg_of(self.graph)

    @cached_property
    def mermaid(self) -> str:
        """A Mermaid flowchart, for Markdown viewers."""
        return mermaid_of(self.graph)

    @cached_property
    def dot(self) -> str:
        """A graph for Graphviz."""
        return dot_of(self.graph)

    def lines(self) -> Iterator[Text]:
        """Yield the lines of the text, each channel in a colour."""
        from rich.text import Text

        drawing = text_of(self.graph)
        for line, rails in zip(drawing.lines, drawing.rails, strict=True):
            text = Text(line)
            for at, rail in enumerate(rails[: len(line)]):
                if rail >= 0:
                    text.stylize(_COLOURS[rail % len(_COLOURS)], at, at + 1)
            yield text

    def __rich_console__(self, _console: object, _options: object) -> Iterator[Text]:
        yield from self.lines()

    def _repr_html_(self) -> str:
        return self.svg  # inline it shrinks to the page's width, and wires show channel and type on hover

    def _repr_svg_(self) -> str:
        return self.svg

    def __str__(self) -> str:
        return self.text

    def __repr__(self) -> str:
        return self.text.rstrip("\n")
