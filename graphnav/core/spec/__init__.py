"""Read YAML: every value with its place, and what files may say, declared."""

from graphnav.core.spec.declared import (
    DIALECT,
    FileFormat,
    Names,
    Range,
    Record,
    Schema,
    key,
    keys_of,
    object_schema,
    param_schema,
    plugin_formats,
    read_record,
    record_object,
)
from graphnav.core.spec.graph_keys import GRAPH, RESERVED_STAGES, STAGE_NAME, GraphKeys
from graphnav.core.spec.run import RecordOption, RunKeys, RunOptions, check_url, option_in
from graphnav.core.spec.spec import (
    TIME_KEYS,
    InputSpec,
    OutputSpec,
    Spec,
    StageSpec,
    outline,
    outline_of,
    parse_spec,
    time_problems,
)
from graphnav.core.spec.value import Entry, Value, parse_scalar
from graphnav.core.spec.write import write_value
from graphnav.core.spec.yaml import MAX_BYTES, parse_yaml, read_bytes

__all__ = [
    "DIALECT",
    "GRAPH",
    "MAX_BYTES",
    "RESERVED_STAGES",
    "STAGE_NAME",
    "TIME_KEYS",
    "Entry",
    "FileFormat",
    "GraphKeys",
    "InputSpec",
    "Names",
    "OutputSpec",
    "Range",
    "Record",
    "RecordOption",
    "RunKeys",
    "RunOptions",
    "Schema",
    "Spec",
    "StageSpec",
    "Value",
    "check_url",
    "key",
    "keys_of",
    "object_schema",
    "option_in",
    "outline",
    "outline_of",
    "param_schema",
    "parse_scalar",
    "parse_spec",
    "parse_yaml",
    "plugin_formats",
    "read_bytes",
    "read_record",
    "record_object",
    "time_problems",
    "write_value",
]
