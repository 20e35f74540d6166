"""Export logs to other formats: video, tables, Foxglove, Rerun."""

from graphnav.watch.export.export_log import Exported, export_log
from graphnav.watch.export.formats import FORMATS
from graphnav.watch.export.selection import Selection, duration_s

__all__ = ["FORMATS", "Exported", "Selection", "duration_s", "export_log"]
