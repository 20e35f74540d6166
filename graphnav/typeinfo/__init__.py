"""Look LCM types up: fields with units and comments, definitions, Java for lcm-spy."""

from graphnav.typeinfo.definitions import definition_files, definition_text
from graphnav.typeinfo.describe_type import describe_type, nested_types, summary_of_type
from graphnav.typeinfo.java import JavaTypes, write_java

__all__ = [
    "JavaTypes",
    "definition_files",
    "definition_text",
    "describe_type",
    "nested_types",
    "summary_of_type",
    "write_java",
]
