"""Tables: one model, and how the terminal, Markdown, HTML, csv and pandas show it."""

from graphnav.core.exports import exports

__getattr__, __dir__ = exports(__name__, __file__)
