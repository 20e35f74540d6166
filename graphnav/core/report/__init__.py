"""Output of a run: its folder, summary table and pictures."""

from graphnav.core.exports import exports

__getattr__, __dir__ = exports(__name__, __file__)
