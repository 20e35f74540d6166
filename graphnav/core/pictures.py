"""Draw the picture of a message by plugins."""

from __future__ import annotations

import errno
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np

from graphnav.arrays import Bytes
from graphnav.core.catalog import Catalog
from graphnav.core.drawing import PictureContext
from graphnav.core.errors import DrawingError, GraphnavError, one_line, raised_line
from graphnav.core.interrupts import CtrlC, third_party_code
from graphnav.core.messages import Message

DRAWING_FAMILY = "view"
_REFUSED = {errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EROFS, errno.EACCES, errno.EIO}
"""Disk errors, which are not the plugin's fault."""


class Pictures:
    """Draws messages by the plugins of the family ``view`` and by every plugin that ``catalog`` has loaded.

    The family is imported with the first picture.
    """

    def __init__(self, catalog: Catalog) -> None:
        self._catalog = catalog

    def draw(self, message: Message, context: PictureContext) -> Bytes | None:
        """Return the picture of a message, (rows, cols, 3) red-green-blue; None if no plugin draws its type.

        Raises
        ------
        DrawingError
            A plugin cannot draw this message, or its result is not a picture that fits.
        CatalogError
            The family cannot be imported.
        """
        self._catalog.load(DRAWING_FAMILY)
        with drawing():
            picture = self._catalog.hook.graphnav_picture(message=message, context=context)
        if picture is None:
            return None
        _check(picture, context)
        return np.ascontiguousarray(picture)


@contextmanager
def drawing() -> Iterator[None]:
    """Convert the exceptions of a drawing plugin to DrawingError, except disk errors and LogError."""
    try:
        with third_party_code():
            yield
    except (GraphnavError, CtrlC):
        raise
    except BaseException as error:
        if isinstance(error, OSError) and error.errno in _REFUSED:
            raise
        raised = raised_line(error)
        raise DrawingError(f"{one_line(error)} ({raised})" if raised else one_line(error)) from error


def _check(picture: Bytes, context: PictureContext) -> None:
    """Raise DrawingError unless the result is a picture that fits the box."""
    shape: tuple[int, ...] = getattr(picture, "shape", ())
    is_picture = isinstance(picture, np.ndarray) and picture.dtype == np.uint8 and len(shape) == 3 and shape[2] == 3
    if not is_picture or not 0 < shape[0] <= context.rows or not 0 < shape[1] <= context.cols:
        raise DrawingError(
            f"graphnav_picture returned {type(picture).__name__} {shape}, not uint8 (rows, cols, 3) "
            f"within {context.rows} x {context.cols}"
        )
