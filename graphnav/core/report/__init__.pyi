# What the rest of graphnav takes of this folder, each imported on first use.

from .folder import make_run_folder, removed_if_empty
from .pictures import LogPictures

__all__ = ["LogPictures", "make_run_folder", "removed_if_empty"]
