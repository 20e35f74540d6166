"""A page as a picture, by a headless Chromium."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

from PIL import Image, ImageChops

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
_OPTIONS = ("--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--hide-scrollbars")
_MARGIN_PX = 20


def draw_page(page: Path, target: Path, size_px: tuple[int, int]) -> bool:
    """Draw a file in a window of ``size_px``, cut below its last line; return whether there is a Chromium to do it."""
    if CHROMIUM is None:
        return False
    width, height = size_px
    window = [f"--window-size={width},{height}", f"--screenshot={target}", f"--user-data-dir={target}.profile"]
    patience = "--virtual-time-budget=10000"
    subprocess.run(
        [CHROMIUM, *_OPTIONS, *window, patience, page.resolve().as_uri()], check=True, capture_output=True, timeout=180
    )
    shutil.rmtree(f"{target}.profile", ignore_errors=True)
    with Image.open(target) as drawn:
        page_image = drawn.convert("RGB")
    ground = Image.new("RGB", page_image.size, page_image.getpixel((0, page_image.height - 1)))
    if box := ImageChops.difference(page_image, ground).getbbox():
        page_image.crop((0, 0, width, min(height, box[3] + _MARGIN_PX))).save(target)
    return True
