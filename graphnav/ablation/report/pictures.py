"""Pictures inside the page, made small enough that the page stays one file that opens at once."""

from __future__ import annotations

import base64
import io
from pathlib import Path

from graphnav.ablation.report.html import Html, tag

_COLOURS = 96


def embedded(file: Path, about: Html, most_px: int) -> Html:
    """Return the picture ``file`` as part of the page, at most ``most_px`` wide, with few colours.

    A text stands for a picture that cannot be read.
    """
    from PIL import Image, UnidentifiedImageError  # noqa: PLC0415 - comes with Matplotlib; only a report needs it

    try:
        with Image.open(file) as opened:
            picture = opened.convert("RGB")
    except (OSError, UnidentifiedImageError) as error:
        return tag("p", f"A picture is missing: {type(error).__name__}", class_="note warn")
    if picture.width > most_px:
        picture = picture.resize((most_px, round(picture.height * most_px / picture.width)), Image.Resampling.LANCZOS)
    few = picture.quantize(_COLOURS, method=Image.Quantize.MEDIANCUT, dither=Image.Dither.NONE)
    data = io.BytesIO()
    few.save(data, "PNG", optimize=True)
    text = base64.b64encode(data.getvalue()).decode("ascii")
    size = f'width="{picture.width}" height="{picture.height}"'
    return f'<img alt="{about}" {size} loading="lazy" src="data:image/png;base64,{text}">'
