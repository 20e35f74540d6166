"""Take over the results of finished studies into docs/results, and make the tables of its page again.

python tools/gen_results.py study/suite study/paper    take over what ships of studies
python tools/gen_results.py                            make the tables again
python tools/gen_results.py --check                    say what the page claims and the results do not bear out
"""

from __future__ import annotations

import argparse
import re
import shutil
import sys
from collections.abc import Iterator
from functools import cache
from pathlib import Path

from result_pages.claims import claims, listed_claims, unchecked
from result_pages.rivals import with_rivals
from result_pages.shipped_results import RESULTS, ShippedResults
from result_pages.tables import with_tables

from graphnav.core.errors import UserError

PAGE = RESULTS / "README.md"
"""Every statement of it that gives a number or compares has a check."""
_ROOT = RESULTS.parents[1]
ALSO_CLAIM = (_ROOT / "docs" / "explanation" / "limits.md",)
"""Pages of which the statements with a check are checked, too."""
FRONT_PAGE, FRONT_PAGE_CLAIMS = _ROOT / "README.md", RESULTS / "front_page.yaml"
"""A page without comments, and the list of what it says."""
FILES = ("results.csv", "metrics.csv", "table.md")
"""Files of a study's folder that ship."""
PICTURE = "decompose.png"
"""Ships, too, where a study has it."""
_FOLDER = re.compile(r"(-o )\S*/(?=[^/\s`]+)")
"""A study's folder in the command that its table names, up to its own name."""


def problems(page: Path = PAGE, folder: Path = RESULTS) -> Iterator[str]:
    """Yield what a page claims and the results do not bear out, what nothing checks, and tables that are not fresh."""

    @cache
    def read(study: str) -> ShippedResults:
        return ShippedResults.read(study, folder)

    text = page.read_text(encoding="utf-8")
    yield from unchecked(text)
    for one in (page, *(ALSO_CLAIM if page == PAGE else ())):
        for claim in claims(one.read_text(encoding="utf-8")):
            yield from (f"{one.name}, {problem}" for problem in claim.problems(read(claim.study)))
    if page == PAGE:
        for claim in listed_claims(FRONT_PAGE_CLAIMS.read_text("utf-8"), FRONT_PAGE.read_text("utf-8")):
            yield from (f"{FRONT_PAGE_CLAIMS.name}, {problem}" for problem in claim.problems(read(claim.study)))
    if with_tables(with_rivals(text, folder), read) != text:
        yield "the tables are not fresh; run python tools/gen_results.py"


def placeless(table: str) -> str:
    """Return a study's table without the place of its folder on the machine that made it."""
    return _FOLDER.sub(r"\1", table)


def main() -> int:
    """Take over, generate, or check; return 1 if something is wrong."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("study", nargs="*", type=Path, help="folder of a finished study")
    parser.add_argument("--check", action="store_true", help="change nothing, return 1 if something is wrong")
    args = parser.parse_args()
    if args.check:
        found = list(problems())
        print("\n".join(found or ["every claim is borne out"]))
        return 1 if found else 0
    for study in args.study:
        target = RESULTS / study.resolve().name
        target.mkdir(exist_ok=True)
        for name in (*FILES, *([PICTURE] if (study / PICTURE).is_file() else [])):
            shutil.copyfile(study / name, target / name)
        table = target / "table.md"
        table.write_text(placeless(table.read_text(encoding="utf-8")), encoding="utf-8")
    PAGE.write_text(with_tables(with_rivals(PAGE.read_text(encoding="utf-8"))), encoding="utf-8")
    return 0


if __name__ == "__main__":
    try:
        sys.exit(main())
    except UserError as error:
        sys.exit(str(error))
