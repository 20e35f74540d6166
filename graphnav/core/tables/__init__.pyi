# What the rest of graphnav takes of this folder, each imported on first use.

from .table import Cell, Column, Table, Tone, escaped
from .terminal import cut, fitted, folded, print_fitted, print_folded

__all__ = ["Cell", "Column", "Table", "Tone", "cut", "escaped", "fitted", "folded", "print_fitted", "print_folded"]
