# What the rest of graphnav takes of this folder, each imported on first use.

from .folder import make_run_folder, removed_if_empty
from .pictures import draw_all, draw_frames, draw_rows, draw_sheet

__all__ = ["draw_all", "draw_frames", "draw_rows", "draw_sheet", "make_run_folder", "removed_if_empty"]
