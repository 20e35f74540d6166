# What the rest of graphnav takes of this folder, each imported on first use.

from .describe import definition_files, describe_type, nested_types
from .lcm_gen import file_of_lcm
from .named_types import load_types

__all__ = [
    "definition_files",
    "describe_type",
    "file_of_lcm",
    "load_types",
    "nested_types",
]
