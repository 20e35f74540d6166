"""A picture of one message, drawn by the plugins that draw."""

from graphnav.pictures.context import PictureContext, no_message, no_path
from graphnav.pictures.pictures import DRAWING_FAMILY, Pictures, drawing

__all__ = ["DRAWING_FAMILY", "PictureContext", "Pictures", "drawing", "no_message", "no_path"]
