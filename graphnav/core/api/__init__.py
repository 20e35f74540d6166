"""The Python interface for notebooks and scripts; `graphnav` exports its names."""

from graphnav.core.exports import exports

__getattr__, __dir__ = exports(__name__, __file__)
