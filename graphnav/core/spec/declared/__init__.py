"""Declared files: classes whose fields read, check and describe the keys of YAML files."""

from graphnav.core.spec.declared.file_format import FileFormat, plugin_formats
from graphnav.core.spec.declared.json_schema import DIALECT, Schema, object_schema, param_schema, record_object
from graphnav.core.spec.declared.read_record import key_problems, read_record
from graphnav.core.spec.declared.record import Names, Range, Record, key, keys_of

__all__ = [
    "DIALECT",
    "FileFormat",
    "Names",
    "Range",
    "Record",
    "Schema",
    "key",
    "key_problems",
    "keys_of",
    "object_schema",
    "param_schema",
    "plugin_formats",
    "read_record",
    "record_object",
]
