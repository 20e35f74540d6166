"""The authoring API of stages: parameters, ports and `step`."""

from graphnav.core.stage.describe import describe, plain_data, summary_of
from graphnav.core.stage.former_names import FormerNames
from graphnav.core.stage.metric import MEASURED, UNDEFINED, Better, Metric, metrics_of
from graphnav.core.stage.param import Param, param, params_of
from graphnav.core.stage.port import Age, Latest, Port, Since, Stamp, Stamped, ports_of
from graphnav.core.stage.run_metrics import measured_metrics, reported_metrics
from graphnav.core.stage.stage import (
    MAY_READ_TRUTH,
    Finished,
    LiveSource,
    Role,
    Source,
    Stage,
    Unnoticed,
    tell_readers,
    tell_run_seed,
    tell_wake,
)
from graphnav.core.stage.units import unit_of

__all__ = [
    "MAY_READ_TRUTH",
    "MEASURED",
    "UNDEFINED",
    "Age",
    "Better",
    "Finished",
    "FormerNames",
    "Latest",
    "LiveSource",
    "Metric",
    "Param",
    "Port",
    "Role",
    "Since",
    "Source",
    "Stage",
    "Stamp",
    "Stamped",
    "Unnoticed",
    "describe",
    "measured_metrics",
    "metrics_of",
    "param",
    "params_of",
    "plain_data",
    "ports_of",
    "reported_metrics",
    "summary_of",
    "tell_readers",
    "tell_run_seed",
    "tell_wake",
    "unit_of",
]
