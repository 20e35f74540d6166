# What the rest of graphnav takes of this folder, each imported on first use.

from .table import Cell, Column, Table, Tone, escaped

__all__ = ["Cell", "Column", "Table", "Tone", "escaped"]
