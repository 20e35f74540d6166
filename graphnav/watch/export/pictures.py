"""Export the images of a channel as picture files, unchanged."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from graphnav import Image, UserError
from graphnav.watch.export.files.atomic_path import placed_folder
from graphnav.watch.export.reader import Reader


def write_pictures(reader: Reader, target: Path, channel: str | None, *, force: bool) -> tuple[int, list[Path]]:
    """Write every image of ``channel`` to the folder ``target``; return their number and the files.

    Files are Netpbm (``.pgm`` for gray, ``.ppm`` for colour), which holds the pixels as they are, and are named by the
    images' stamps in microseconds.

    Raises
    ------
    UserError
        No channel of images is selected, or the target is not writable.
    GraphnavError
        Writing fails.
    """
    images = [name for name in reader.recording.channels if reader.message_type(name) is Image]
    selected = [name for name in images if name in reader.channels]
    if channel is None and len(selected) == 1:
        channel = selected[0]
    if channel is None or channel not in images:
        what = (
            f"{len(selected)} channels of images are selected"
            if channel is None
            else f"channel '{channel}' holds no images"
        )
        known = f"select one with --channel: {', '.join(images)}" if images else "export a log that holds images"
        raise UserError.of(what, known)
    names = []
    with placed_folder(target, source=reader.recording.path, force=force) as folder:
        for sample in reader.of(channel):
            image = reader.message(channel, sample.fields)
            if isinstance(image, Image):
                name = f"{sample.fields['utime']:016d}.{'pgm' if image.pixels.ndim == 2 else 'ppm'}"
                (folder / name).write_bytes(_netpbm(image))
                names.append(name)
    return len(names), [target / name for name in names]


def _netpbm(image: Image) -> bytes:
    rows, cols = image.pixels.shape[:2]
    kind = "P5" if image.pixels.ndim == 2 else "P6"
    return f"{kind}\n{cols} {rows}\n255\n".encode() + np.ascontiguousarray(image.pixels).tobytes()
