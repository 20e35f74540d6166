"""Look up LCM types: fields with units and comments, definitions, Java code for lcm-spy."""

from graphnav.core.exports import exports

__getattr__, __dir__ = exports(__name__, __file__)
