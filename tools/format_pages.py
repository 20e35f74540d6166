"""Generate the reference pages of files that are declared (maps, studies); --check says whether they are fresh."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path

from graphnav.ablation.study import STUDY
from graphnav.catalog import Catalog
from graphnav.spec import plugin_formats

FOLDER = Path(__file__).resolve().parent.parent / "docs" / "reference"


def format_page(name: str) -> str:
    """Return the page of a kind of file, by the name that ``graphnav schema --of`` takes."""
    formats = {STUDY.name: STUDY, **plugin_formats(Catalog())}
    return formats[name].reference()


PAGES: Mapping[str, Callable[[], str]] = {
    "maps.md": partial(format_page, "map"),
    "studies.md": partial(format_page, "study"),
}
"""By path in ``docs/reference``."""


def stale() -> list[str]:
    """Return the pages whose file differs from what would be generated."""
    return [name for name, make in PAGES.items() if (FOLDER / name).read_text(encoding="utf-8") != make()]


def main() -> int:
    """Generate, or with --check compare; return 1 if something differs."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--check", action="store_true", help="change nothing, return 1 if a page is not fresh")
    if parser.parse_args().check:
        print("\n".join([f"not fresh: {name}; run python tools/format_pages.py" for name in stale()] or ["fresh"]))
        return 1 if stale() else 0
    for name, make in PAGES.items():
        (FOLDER / name).write_text(make(), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
