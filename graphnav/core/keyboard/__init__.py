"""Single keys from a terminal."""

from graphnav.core.keyboard.decoder import KeyDecoder
from graphnav.core.keyboard.terminal import Terminal

__all__ = ["KeyDecoder", "Terminal"]
