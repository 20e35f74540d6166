"""Visual navigation as a dataflow graph: plugin stages, LCM channels, a simulated robot to close the loop."""

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from graphnav.adapter import Adapter
    from graphnav.api.draw import Drawing, draw
    from graphnav.api.finished_run import Run, RunError
    from graphnav.api.load import check, load
    from graphnav.api.logs.log import Log, open_log
    from graphnav.api.run import run
    from graphnav.api.studies.ablate import ablate
    from graphnav.api.studies.finished_study import Study
    from graphnav.continuity import Continuity
    from graphnav.errors import (
        DeclarationError,
        GraphnavError,
        ParamError,
        Place,
        Problem,
        Suggestion,
        UserError,
        did_you_mean,
        shown_path,
    )
    from graphnav.graph import Graph
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
    from graphnav.pictures import PictureContext, VideoFrames
    from graphnav.record import Recording
    from graphnav.spec import FileFormat, Range, Record, Value, key
    from graphnav.stage import (
        MEASURED,
        UNDEFINED,
        Age,
        Finished,
        Latest,
        Metric,
        Role,
        Since,
        Source,
        Stage,
        Stamp,
        Stamped,
        param,
    )

__version__ = "0.2.0"

_HOMES = {
    "graphnav.adapter": ("Adapter",),
    "graphnav.api.studies.ablate": ("ablate",),
    "graphnav.api.draw": ("Drawing", "draw"),
    "graphnav.api.finished_run": ("Run", "RunError"),
    "graphnav.api.studies.finished_study": ("Study",),
    "graphnav.api.load": ("check", "load"),
    "graphnav.api.logs.log": ("Log", "open_log"),
    "graphnav.api.run": ("run",),
    "graphnav.continuity": ("Continuity",),
    "graphnav.errors": (
        "DeclarationError",
        "GraphnavError",
        "ParamError",
        "Place",
        "Problem",
        "Suggestion",
        "UserError",
        "did_you_mean",
        "shown_path",
    ),
    "graphnav.graph": ("Graph",),
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
    "graphnav.pictures": ("PictureContext", "VideoFrames"),
    "graphnav.record": ("Recording",),
    "graphnav.spec": ("FileFormat", "Range", "Record", "Value", "key"),
    "graphnav.stage": (
        "MEASURED",
        "UNDEFINED",
        "Age",
        "Finished",
        "Latest",
        "Metric",
        "Role",
        "Since",
        "Source",
        "Stage",
        "Stamp",
        "Stamped",
        "param",
    ),
}
_HOME_OF = {name: module for module, names in _HOMES.items() for name in names}

__all__ = [
    "MEASURED",
    "UNDEFINED",
    "About",
    "Adapter",
    "Age",
    "Continuity",
    "DeclarationError",
    "Drawing",
    "FileFormat",
    "Finished",
    "Flow",
    "Goal",
    "Graph",
    "GraphnavError",
    "GuardState",
    "Image",
    "Latest",
    "Log",
    "Map",
    "Message",
    "Metric",
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
    "Range",
    "Record",
    "Recording",
    "Role",
    "Run",
    "RunError",
    "Since",
    "Source",
    "Stage",
    "Stamp",
    "Stamped",
    "State",
    "Status",
    "Steering",
    "Stop",
    "Study",
    "Suggestion",
    "Truth",
    "Twist",
    "UserError",
    "Value",
    "VideoFrames",
    "__version__",
    "ablate",
    "block_sum",
    "check",
    "coarsen",
    "did_you_mean",
    "draw",
    "hookimpl",
    "key",
    "load",
    "open_log",
    "param",
    "run",
    "shown_path",
]


def __getattr__(name: str) -> Any:
    """Import a public name on first use, so that ``graphnav --help`` does not load numpy."""
    if name not in _HOME_OF:
        raise AttributeError(f"module 'graphnav' has no attribute '{name}'")
    value = getattr(importlib.import_module(_HOME_OF[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
