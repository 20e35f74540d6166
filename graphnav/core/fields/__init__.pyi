# What the rest of graphnav takes of this folder, each imported on first use.

from .field_columns import all_columns, columns_of
from .field_path import MISSING, FieldPath, parse_field
from .field_summary import declared, described, summarised, value_text
from .plain_values import nested, plain
from .selection import Selection

__all__ = [
    "MISSING",
    "FieldPath",
    "Selection",
    "all_columns",
    "columns_of",
    "declared",
    "described",
    "nested",
    "parse_field",
    "plain",
    "summarised",
    "value_text",
]
