"""The fields of messages: paths, columns, summaries, trees."""

from graphnav.core.exports import exports

__getattr__, __dir__ = exports(__name__, __file__)
