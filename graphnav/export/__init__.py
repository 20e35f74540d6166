"""Export logs to other formats: video, tables, Foxglove, Rerun."""

from graphnav.export.export_log import Exported, export_log
from graphnav.export.formats import FORMATS
from graphnav.export.selection import Selection, duration_s

__all__ = ["FORMATS", "Exported", "Selection", "duration_s", "export_log"]
