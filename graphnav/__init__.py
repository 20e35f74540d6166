"""Visual navigation as a dataflow graph: plugin stages, LCM channels, a simulated robot to close the loop."""

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from graphnav.adapter import Adapter
    from graphnav.continuity import Continuity
    from graphnav.errors import (
        DeclarationError,
        GraphnavError,
        ParamError,
        Place,
        Problem,
        UserError,
        did_you_mean,
        shown_path,
    )
    from graphnav.grid import block_sum, coarsen
    from graphnav.hooks import hookimpl
    from graphnav.messages import (
        About,
        Flow,
        Goal,
        GuardState,
        Image,
        Map,
        Message,
        Motion,
        Odometry,
        Planar,
        PlanarModel,
        Plane,
        Potential,
        State,
        Status,
        Steering,
        Stop,
        Truth,
        Twist,
    )
    from graphnav.pictures import PictureContext
    from graphnav.record import Recording
    from graphnav.stage import Age, Finished, Latest, Role, Since, Source, Stage, Stamp, Stamped, param

__version__ = "0.2.0"

_HOMES = {
    "graphnav.adapter": ("Adapter",),
    "graphnav.continuity": ("Continuity",),
    "graphnav.errors": (
        "DeclarationError",
        "GraphnavError",
        "ParamError",
        "Place",
        "Problem",
        "UserError",
        "did_you_mean",
        "shown_path",
    ),
    "graphnav.grid": ("block_sum", "coarsen"),
    "graphnav.hooks": ("hookimpl",),
    "graphnav.messages": (
        "About",
        "Flow",
        "Goal",
        "GuardState",
        "Image",
        "Map",
        "Message",
        "Motion",
        "Odometry",
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
    ),
    "graphnav.pictures": ("PictureContext",),
    "graphnav.record": ("Recording",),
    "graphnav.stage": ("Age", "Finished", "Latest", "Role", "Since", "Source", "Stage", "Stamp", "Stamped", "param"),
}
_HOME_OF = {name: module for module, names in _HOMES.items() for name in names}

__all__ = [
    "About",
    "Adapter",
    "Age",
    "Continuity",
    "DeclarationError",
    "Finished",
    "Flow",
    "Goal",
    "GraphnavError",
    "GuardState",
    "Image",
    "Latest",
    "Map",
    "Message",
    "Motion",
    "Odometry",
    "ParamError",
    "PictureContext",
    "Place",
    "Planar",
    "PlanarModel",
    "Plane",
    "Potential",
    "Problem",
    "Recording",
    "Role",
    "Since",
    "Source",
    "Stage",
    "Stamp",
    "Stamped",
    "State",
    "Status",
    "Steering",
    "Stop",
    "Truth",
    "Twist",
    "UserError",
    "__version__",
    "block_sum",
    "coarsen",
    "did_you_mean",
    "hookimpl",
    "param",
    "shown_path",
]


def __getattr__(name: str) -> Any:
    """Import a public name when it is first used, so that ``graphnav --help`` loads no numpy."""
    if name not in _HOME_OF:
        raise AttributeError(f"module 'graphnav' has no attribute '{name}'")
    value = getattr(importlib.import_module(_HOME_OF[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
