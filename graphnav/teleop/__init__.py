"""Drive by keys: a terminal's keys in, twists and stops out."""

from graphnav.teleop.drive import Drive
from graphnav.teleop.keys import Key, KeyDecoder
from graphnav.teleop.session import Session
from graphnav.teleop.terminal import Terminal

__all__ = ["Drive", "Key", "KeyDecoder", "Session", "Terminal"]
