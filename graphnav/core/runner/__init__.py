"""The engine that runs graphs, the schedule of lockstep, and what writes the folder of a run."""

from graphnav.core.exports import exports

__getattr__, __dir__ = exports(__name__, __file__)
