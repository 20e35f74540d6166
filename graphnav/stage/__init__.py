"""The authoring API of stages: parameters, ports and `step`."""

from graphnav.stage.describe import describe, plain_data, summary_of, unit_of
from graphnav.stage.param import Param, param, params_of
from graphnav.stage.port import Age, Latest, Port, Ports, Since, Stamp, Stamped, ports_of
from graphnav.stage.stage import Finished, Role, Source, Stage

__all__ = [
    "Age",
    "Finished",
    "Latest",
    "Param",
    "Port",
    "Ports",
    "Role",
    "Since",
    "Source",
    "Stage",
    "Stamp",
    "Stamped",
    "describe",
    "param",
    "params_of",
    "plain_data",
    "ports_of",
    "summary_of",
    "unit_of",
]
