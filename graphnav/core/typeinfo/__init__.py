"""LCM types: those of other packages and of ``.lcm`` files, fields with units and comments, definitions."""

from graphnav.core.exports import exports

__getattr__, __dir__ = exports(__name__, __file__)
