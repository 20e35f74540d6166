"""Embed pictures in the page, reduced in size."""

from __future__ import annotations

import base64
import io
from pathlib import Path

from graphnav.ablation.report.html.markup import Html, esc, tag

_QUALITY = 82


def embedded_picture(file: Path, about: Html, max_px: int) -> Html:
    """Return the picture ``file`` as part of the page, at most ``max_px`` wide.

    WebP keeps the colours of small marks at a fifth of PNG's size. A text stands for a picture that cannot be read.
    """
    from PIL import Image, features

    try:
        with Image.open(file) as opened:
            picture = opened.convert("RGB")
    except (OSError, SyntaxError) as error:
        return tag("p", esc(f"{file.name} cannot be read: {type(error).__name__}"), class_="note warn")
    if picture.width > max_px:
        picture = picture.resize((max_px, round(picture.height * max_px / picture.width)), Image.Resampling.LANCZOS)
    kind = "webp" if features.check("webp") else "png"
    data = io.BytesIO()
    picture.save(data, kind.upper(), quality=_QUALITY)
    text = base64.b64encode(data.getvalue()).decode("ascii")
    size = f'width="{picture.width}" height="{picture.height}"'
    return f'<img alt="{about}" {size} loading="lazy" src="data:image/{kind};base64,{text}">'
