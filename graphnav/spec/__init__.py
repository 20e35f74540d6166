"""What a graph's YAML says, every value with its place."""

from graphnav.spec.outside import TIME_KEYS, InputSpec, OutputSpec, QueueSpec, parse_times
from graphnav.spec.run import RunOptions, check_url
from graphnav.spec.scalar import Scalar, parse_scalar
from graphnav.spec.spec import Spec, StageSpec, parse_spec
from graphnav.spec.value import Entry, Value
from graphnav.spec.write import write_value
from graphnav.spec.yaml import MAX_BYTES, parse_yaml

__all__ = [
    "MAX_BYTES",
    "TIME_KEYS",
    "Entry",
    "InputSpec",
    "OutputSpec",
    "QueueSpec",
    "RunOptions",
    "Scalar",
    "Spec",
    "StageSpec",
    "Value",
    "check_url",
    "parse_scalar",
    "parse_spec",
    "parse_times",
    "parse_yaml",
    "write_value",
]
