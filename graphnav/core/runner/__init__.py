"""The engine that runs graphs, and the schedule of lockstep."""

from graphnav.core.exports import exports

__getattr__, __dir__ = exports(__name__, __file__)
