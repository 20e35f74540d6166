"""The shipped message types."""

from graphnav.messages.local_map import LocalMap
from graphnav.messages.message import ZERO_MEANS, FieldError, Message, snake_case
from graphnav.messages.robot import Goal, GuardState, Map, Motion, Odometry, OdometryCheck, State, Steering, Stop, Twist
from graphnav.messages.run import About, Fired, Gap, Status
from graphnav.messages.vision import Components, Flow, Image, Planar, PlanarModel, Plane, Potential, Truth

__all__ = [
    "ZERO_MEANS",
    "About",
    "Components",
    "FieldError",
    "Fired",
    "Flow",
    "Gap",
    "Goal",
    "GuardState",
    "Image",
    "LocalMap",
    "Map",
    "Message",
    "Motion",
    "Odometry",
    "OdometryCheck",
    "Planar",
    "PlanarModel",
    "Plane",
    "Potential",
    "State",
    "Status",
    "Steering",
    "Stop",
    "Truth",
    "Twist",
    "snake_case",
]
