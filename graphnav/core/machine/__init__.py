"""The machine: its instruction set, threads, files, sockets, terminal, installed packages."""

from graphnav.core.exports import exports

__getattr__, __dir__ = exports(__name__, __file__)
