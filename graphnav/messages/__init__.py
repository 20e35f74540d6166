"""The message types that ship."""

from graphnav.messages.driving import Goal, Map, Motion, State, Steering, Twist
from graphnav.messages.message import Message, snake_case
from graphnav.messages.running import About
from graphnav.messages.vision import Flow, Image, Planar, PlanarModel, Plane, Potential, Truth

__all__ = [
    "About",
    "Flow",
    "Goal",
    "Image",
    "Map",
    "Message",
    "Motion",
    "Planar",
    "PlanarModel",
    "Plane",
    "Potential",
    "State",
    "Steering",
    "Truth",
    "Twist",
    "snake_case",
]
