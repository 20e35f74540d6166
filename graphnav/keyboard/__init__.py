"""Single keys from a terminal."""

from graphnav.keyboard.decoder import KeyDecoder
from graphnav.keyboard.terminal import Terminal

__all__ = ["KeyDecoder", "Terminal"]
