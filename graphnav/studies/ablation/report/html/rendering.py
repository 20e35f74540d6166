"""Templates, numbers and pictures in HTML."""

from __future__ import annotations

import base64
import io
import math
from collections.abc import Sequence
from pathlib import Path

from markupsafe import Markup

from graphnav.core.html_templates import rendered as rendered_of
from graphnav.studies.ablation.report import number_format
from graphnav.studies.ablation.results import Estimate


def rendered(template: str, /, **values: object) -> Markup:
    """Return ``templates/<template>`` with ``values`` filled in; strings are escaped."""
    return rendered_of("graphnav.studies.ablation.report.html", template, **values)


MINUS = "\N{MINUS SIGN}"


def number(value: float, form: str, sign: str = "") -> str:
    """Return a number in a format, with ``sign`` where it is above zero; zero has none."""
    return number_format.number(value, form, sign).replace("-", MINUS)


def estimate_text(found: Estimate) -> str:
    """Return ``0.94 [0.84, 0.98]``, marked where the interval is approximate; without an interval the mean alone."""
    mark = number_format.APPROXIMATE if found.is_approximate else ""
    return estimated(found.mean, found.low, found.high).replace(" [", f" {mark}[")


def estimated(mean: float, low: float, high: float, *, signed: bool = False) -> str:
    """Return ``0.94 [0.84, 0.98]``; without an interval the mean alone."""
    form = number_format.format_of(mean, low, high)
    text = number(mean, form, "+" if signed else "")
    if not (math.isfinite(low) and math.isfinite(high)):
        return text
    return f"{text} [{number(low, form)}, {number(high, form)}]"


def counted(n: int, one: str, many: str = "") -> str:
    """Return ``1 world``, ``2 worlds``."""
    return f"{n} {one if n == 1 else many or one + 's'}"


def means_text(means: Sequence[float], *, signed: bool = False) -> str:
    """Return the range of some means: ``0.86 to 0.98``."""
    ends = (min(means), max(means))
    largest = max(map(abs, ends))
    places = max(2, -math.floor(math.log10(largest))) if largest else 2
    form = f".{places}f" if places <= number_format.MAX_DECIMALS else number_format.TINY
    return " to ".join(dict.fromkeys(("+" if signed and end > 0 else "") + number(end, form) for end in ends))


_QUALITY = 82


def embedded_picture(file: Path, about: str, max_px: int) -> Markup:
    """Return the picture ``file`` as part of the page, at most ``max_px`` wide.

    WebP keeps the colours of small marks at a fifth of PNG's size. A sentence replaces a picture that cannot be read.
    """
    from PIL import Image, features

    try:
        with Image.open(file) as opened:
            picture = opened.convert("RGB")
    except (OSError, SyntaxError) as error:
        return rendered("picture.html", file=file.name, error=type(error).__name__)
    if picture.width > max_px:
        picture = picture.resize((max_px, round(picture.height * max_px / picture.width)), Image.Resampling.LANCZOS)
    kind = "webp" if features.check("webp") else "png"
    data = io.BytesIO()
    picture.save(data, kind.upper(), quality=_QUALITY)
    encoded = base64.b64encode(data.getvalue()).decode("ascii")
    size = {"width": picture.width, "height": picture.height}
    return rendered("picture.html", error="", about=about, kind=kind, data=encoded, **size)
