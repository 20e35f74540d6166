"""The command line: `graphnav COMMAND`, and what the commands of all rooms share."""

from graphnav.core.exports import exports

__getattr__, __dir__ = exports(__name__, __file__)
