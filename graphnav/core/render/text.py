"""Draw a graph for the terminal: stages in one column, channels as rails on the right."""

from __future__ import annotations

from dataclasses import dataclass, field

from graphnav.core.graph import Graph
from graphnav.core.render.boxes import Box, Wire, as_fired, boxes_of, wires_of

_LINES = {
    "UD": "│", "LR": "─", "DL": "╮", "UL": "╯", "UDL": "┤", "UDLR": "┼",
}  # fmt: skip
_SAMPLED = "╌"
NO_RAIL = -1


@dataclass
class TextDrawing:
    """Lines of characters, and for each character the rail (channel) that it belongs to, `NO_RAIL` for boxes."""

    lines: list[str] = field(default_factory=list)
    rails: list[list[int]] = field(default_factory=list)

    def __str__(self) -> str:
        return "\n".join(self.lines) + "\n"


@dataclass
class _Rail:
    """A channel's vertical line: from the row of its writer to those of its readers."""

    writer: int
    readers: dict[int, bool]
    """The row of each reader, and whether it samples."""
    column: int = 0

    @property
    def top(self) -> int:
        return min(self.writer, *self.readers)

    @property
    def bottom(self) -> int:
        return max(self.writer, *self.readers)


def text_of(graph: Graph) -> TextDrawing:
    """Return the drawing: inputs and sources, other stages in firing order, outputs.

    A rail leaves the box of its writer at the port and enters readers at an arrow head; a dashed line is sampled.
    """
    boxes = boxes_of(graph)
    lines: list[str] = []
    rows: dict[str, int] = {}
    width = max(len(line) for box in boxes for line in _content(box, 0))
    for box in as_fired(graph, boxes):
        ports = [*(f"{box.key}<{port.name}" for port in box.inputs), *(port.channel.ref for port in box.outputs)]
        lines.append(f"┌{'─' * (width + 2)}┐")
        rows |= {port: len(lines) + number for number, port in enumerate(ports, start=1)}
        lines += [f"│ {line.ljust(width)} │" for line in _content(box, width)]
        lines.append(f"└{'─' * (width + 2)}┘")
    rails = _rails(wires_of(boxes), rows)
    _place(rails)
    return _draw(lines, rails)


def _content(box: Box, width: int) -> list[str]:
    gap = max(2, width - len(box.name) - len(box.use))
    lines = [f"{box.name}{' ' * gap}{box.use}"]
    lines += [
        f"  ◂ {port.name}" + (f" ({port.reading})" if port.reading else "") + ("" if port.channel else ", open")
        for port in box.inputs
    ]
    for port in box.outputs:
        alias = f" {'from' if box.kind == 'input' else 'as'} {port.alias}" if port.alias else ""
        lines.append(f"  ▸ {port.name}: {port.channel.type_text}{alias}")
    return lines


def _rails(wires: list[Wire], rows: dict[str, int]) -> list[_Rail]:
    rails: dict[str, _Rail] = {}
    for wire in wires:
        rail = rails.setdefault(wire.channel.ref, _Rail(rows[wire.channel.ref], {}))
        rail.readers[rows[f"{wire.reader}<{wire.port}"]] = wire.latest
    return list(rails.values())


def _place(rails: list[_Rail]) -> None:
    """Assign each rail the innermost free column, short rails first."""
    taken: list[set[int]] = []
    for rail in sorted(rails, key=lambda r: (r.bottom - r.top, r.top)):
        rows = set(range(rail.top, rail.bottom + 1))
        column = next((number for number, used in enumerate(taken) if not used & rows), len(taken))
        if column == len(taken):
            taken.append(set())
        taken[column] |= rows
        rail.column = column


def _draw(boxes: list[str], rails: list[_Rail]) -> TextDrawing:
    left = len(boxes[0])
    width = left + 3 * (1 + max((rail.column for rail in rails), default=-1)) + 1
    lines = [list(line.ljust(width)) for line in boxes]
    owners = [[NO_RAIL] * width for _ in boxes]
    directions: dict[tuple[int, int], set[str]] = {}
    for number, rail in enumerate(rails):
        column = left + 3 * rail.column + 2
        for row in range(rail.top, rail.bottom + 1):
            ends = {"U"} if row == rail.bottom else {"D"} if row == rail.top else {"U", "D"}
            directions.setdefault((row, column), set()).update(ends)
            owners[row][column] = number
        for row in (rail.writer, *rail.readers):
            directions[row, column].add("L")
            for between in range(left, column):
                directions.setdefault((row, between), set()).update("LR")
                if owners[row][between] == NO_RAIL:
                    owners[row][between] = number
    for (row, column), found in directions.items():
        lines[row][column] = _LINES["".join(d for d in "UDLR" if d in found)]
    for rail in rails:
        for row, latest in rail.readers.items():
            lines[row][left] = "◂"
            if latest:
                lines[row] = [_SAMPLED if char == "─" and at > left else char for at, char in enumerate(lines[row])]
        lines[rail.writer][left - 1] = "├"
    return TextDrawing(["".join(line).rstrip() for line in lines], owners)
