"""Generate the reference pages of the documentation; --check says whether they are fresh."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from reference_pages import PAGES

FOLDER = Path(__file__).resolve().parent.parent / "docs" / "reference"


def stale() -> list[str]:
    """Return the pages whose file differs from what would be generated."""
    return [name for name, make in PAGES.items() if _text(FOLDER / name) != make()]


def _text(path: Path) -> str | None:
    return path.read_text(encoding="utf-8") if path.exists() else None


def main() -> int:
    """Generate, or with --check compare; return 1 if something differs."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--check", action="store_true", help="change nothing, return 1 if a page is not fresh")
    if parser.parse_args().check:
        differing = stale()
        print("\n".join([f"not fresh: {name}; run python tools/gen_docs.py" for name in differing] or ["fresh"]))
        return 1 if differing else 0
    for name, make in PAGES.items():
        (FOLDER / name).parent.mkdir(parents=True, exist_ok=True)
        (FOLDER / name).write_text(make(), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
