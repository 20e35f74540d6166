"""Look up LCM types: fields with units and comments, definitions, Java code for lcm-spy."""

from graphnav.core.typeinfo.definitions import definition_files, definition_text
from graphnav.core.typeinfo.describe_type import describe_type, nested_types, summary_of_type
from graphnav.core.typeinfo.java import JavaTypes, write_java
from graphnav.core.typeinfo.lcm_files import file_of_lcm
from graphnav.core.typeinfo.load_types import load_types
from graphnav.core.typeinfo.types_jar import types_jar

__all__ = [
    "JavaTypes",
    "definition_files",
    "definition_text",
    "describe_type",
    "file_of_lcm",
    "load_types",
    "nested_types",
    "summary_of_type",
    "types_jar",
    "write_java",
]
