"""Keys of a terminal, one by one."""

from graphnav.keyboard.decoder import KeyDecoder
from graphnav.keyboard.terminal import Terminal

__all__ = ["KeyDecoder", "Terminal"]
