"""Keyboard driving: keys of a terminal in, twists and stops out."""

from graphnav.live.teleop.drive import Drive
from graphnav.live.teleop.keys import Key, Keys
from graphnav.live.teleop.session import Session

__all__ = ["Drive", "Key", "Keys", "Session"]
