"""The shipped message types."""

from graphnav.core.messages.derived import Derived
from graphnav.core.messages.local_map import LocalMap
from graphnav.core.messages.message import ZERO_MEANS, FieldError, Message, snake_case
from graphnav.core.messages.robot import (
    BaseLimits,
    Goal,
    GuardState,
    Map,
    Motion,
    Odometry,
    OdometryCheck,
    RecoveryState,
    State,
    Steering,
    Stop,
    Twist,
)
from graphnav.core.messages.run import About, Changed, Fired, Gap, Status
from graphnav.core.messages.scan import Scan
from graphnav.core.messages.vision import (
    CameraInfo,
    Components,
    Flow,
    FlowDeviation,
    Image,
    Planar,
    PlanarModel,
    Plane,
    Potential,
    Truth,
)

__all__ = [
    "ZERO_MEANS",
    "About",
    "BaseLimits",
    "CameraInfo",
    "Changed",
    "Components",
    "Derived",
    "FieldError",
    "Fired",
    "Flow",
    "FlowDeviation",
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
    "RecoveryState",
    "Scan",
    "State",
    "Status",
    "Steering",
    "Stop",
    "Truth",
    "Twist",
    "snake_case",
]
