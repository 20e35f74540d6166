"""A widget that plots numbers over time in braille dots."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import plotille
from rich.style import Style
from rich.text import Text
from textual.widgets import Static

_COLOURS = (2, 3, 6, 5, 1, 4)
"""Colours of the terminal's palette: green, yellow, cyan, magenta, red, blue."""
MAX_CURVES = len(_COLOURS)
_BESIDE_COLS, _BELOW_ROWS = 20, 3
"""The size of the axes and the legend."""
_HEAD_LINES = 2
"""The lines above the curves: the name of the vertical axis and its limit."""
_MIN_COLS, _MIN_ROWS = 10, 3
_NO_DOTS = "\u2800"
"""The braille blank, which many fonts draw narrower or wider than a space."""
_LARGEST = 1e300
"""Differences of larger numbers may overflow."""

Points = Sequence[tuple[float, float]]


class PlotView(Static):
    """Curves with a legend that shows their newest values."""

    def show(self, curves: Mapping[str, Points], from_s: float, *, with_colour: bool) -> None:
        """Plot curves by name, given as points of time and value, over seconds since ``from_s``."""
        text = plot_text(curves, from_s, self.size.width, self.size.height, with_colour=with_colour)
        self.update(text, layout=False)

    def say(self, text: str) -> None:
        """Show a message in place of a plot."""
        self.update(Text(text), layout=False)


def plot_text(curves: Mapping[str, Points], from_s: float, cols: int, rows: int, *, with_colour: bool) -> Text:
    """Return a plot of ``cols`` x ``rows`` cells with at most six curves; in little space only the legend."""
    drawn = [(name, _drawable(points, from_s)) for name, points in list(curves.items())[:MAX_CURVES]]
    drawn = [(name, points) for name, points in drawn if points]
    legend = Text("  ").join(
        Text(f"• {name} {points[-1][1]:.4g}", _style(place)) for place, (name, points) in enumerate(drawn)
    )
    legend.truncate(cols, overflow="ellipsis")
    wide, high = cols - _BESIDE_COLS, rows - _BELOW_ROWS
    if wide < _MIN_COLS or high < _MIN_ROWS or not drawn:
        return legend
    figure = plotille.Figure()
    figure.width, figure.height = wide, high
    figure.origin = False
    figure.with_colors = with_colour
    figure.color_mode = "byte"
    figure.x_label = "s"
    figure.register_label_formatter(float, _label)
    figure.set_x_limits(*_limits([x for _, points in drawn for x, _ in points]))
    figure.set_y_limits(*_limits([y for _, points in drawn for _, y in points]))
    for place, (_, points) in enumerate(drawn):
        xs, ys = zip(*points, strict=True)
        figure.plot(xs, ys, lc=_COLOURS[place] if with_colour else None)
    lines = Text.from_ansi(figure.show().replace(_NO_DOTS, " ")).split("\n")[_HEAD_LINES:]
    return Text("\n", no_wrap=True, overflow="crop").join([legend, *lines])


def _drawable(points: Points, from_s: float) -> list[tuple[float, float]]:
    return [(time_s - from_s, value) for time_s, value in points if abs(value) < _LARGEST]


def _limits(values: Sequence[float]) -> tuple[float, float]:
    """Return limits with a margin, different even if all values are equal."""
    low, high = min(values), max(values)
    room = 0.05 * (high - low) or max(abs(low) * 0.05, 0.5)
    return low - room, high + room


def _label(value: float, chars: int, delta: float, left: bool = False) -> str:  # noqa: FBT001, FBT002, plotille's signature
    """Return an axis label of ``chars`` characters; ``delta``: the axis's length, shown in steps of a hundredth."""
    digits = 0 if not delta or not math.isfinite(delta) else max(0, 2 - math.floor(math.log10(abs(delta))))
    text = f"{value:.{min(digits, 9)}f}" if abs(value) < 1e6 and digits <= 6 else f"{value:.3g}"
    return text[:chars].ljust(chars) if left else text[:chars].rjust(chars)


def _style(place: int) -> Style:
    return Style(color=f"color({_COLOURS[place]})")
