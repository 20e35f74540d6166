"""Keyboard driving: keys of a terminal in, twists and stops out."""

from graphnav.teleop.drive import Drive
from graphnav.teleop.keys import Key, Keys
from graphnav.teleop.session import Session

__all__ = ["Drive", "Key", "Keys", "Session"]
