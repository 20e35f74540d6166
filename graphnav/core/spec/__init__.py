"""Read YAML: every value with its place, and what files may say, declared."""

from graphnav.core.spec.check_types import check_types
from graphnav.core.spec.declared import (
    DIALECT,
    FileFormat,
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
from graphnav.core.spec.file_bytes import read_bytes
from graphnav.core.spec.outside import TIME_KEYS, InputSpec, OutputSpec, QueueSpec, parse_times
from graphnav.core.spec.run import RECORD_KEYS, RecordOption, RunOptions, check_url, option_in
from graphnav.core.spec.scalar import Scalar, parse_scalar
from graphnav.core.spec.spec import Spec, StageSpec, outline_of, parse_spec
from graphnav.core.spec.value import Entry, Value
from graphnav.core.spec.write import write_value
from graphnav.core.spec.yaml import MAX_BYTES, parse_yaml

__all__ = [
    "DIALECT",
    "MAX_BYTES",
    "RECORD_KEYS",
    "TIME_KEYS",
    "Entry",
    "FileFormat",
    "InputSpec",
    "OutputSpec",
    "QueueSpec",
    "Range",
    "Record",
    "RecordOption",
    "RunOptions",
    "Scalar",
    "Schema",
    "Spec",
    "StageSpec",
    "Value",
    "check_types",
    "check_url",
    "key",
    "keys_of",
    "object_schema",
    "option_in",
    "outline_of",
    "param_schema",
    "parse_scalar",
    "parse_spec",
    "parse_times",
    "parse_yaml",
    "plugin_formats",
    "read_bytes",
    "read_record",
    "record_object",
    "write_value",
]
