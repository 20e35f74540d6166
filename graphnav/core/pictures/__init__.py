"""Pictures of single messages, drawn by plugins."""

from graphnav.core.pictures.context import PictureContext
from graphnav.core.pictures.pictures import DRAWING_FAMILY, Pictures, drawing
from graphnav.core.pictures.video import VideoFrames

__all__ = ["DRAWING_FAMILY", "PictureContext", "Pictures", "VideoFrames", "drawing"]
