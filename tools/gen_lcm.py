"""Generate lcmtypes/graphnav_lcm from lcmtypes/*.lcm with the wheel's lcm-gen; --check says whether it is fresh."""

from __future__ import annotations

import argparse
import re
import shutil
import subprocess
import sys
import sysconfig
import tempfile
from pathlib import Path

TYPES = Path(__file__).resolve().parent.parent / "lcmtypes"
PACKAGE = TYPES / "graphnav_lcm"


def generate(folder: Path) -> Path:
    """Run lcm-gen on every type definition; return the package that it makes in ``folder``."""
    command = [str(Path(sysconfig.get_path("scripts")) / "lcm-gen"), "-p", "--ppath", str(folder)]
    subprocess.run([*command, *map(str, sorted(TYPES.glob("*.lcm")))], check=True)
    return folder / PACKAGE.name


def stale(fresh: Path) -> list[str]:
    """Return the names of files that differ between the package and a fresh one."""
    names = {path.name for folder in (PACKAGE, fresh) for path in folder.glob("*.py")}
    return sorted(name for name in names if _text(PACKAGE / name) != _text(fresh / name))


def _text(path: Path) -> str | None:
    """Return a generated file without the version of lcm-gen, None if there is no such file."""
    return re.sub(r"^lcm-gen [\d.]+$", "", path.read_text(), flags=re.MULTILINE) if path.exists() else None


def main() -> int:
    """Generate, or with --check compare; return 1 if something differs."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--check", action="store_true", help="change nothing, return 1 if a file is not fresh")
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        fresh = generate(Path(scratch))
        if args.check:
            differing = stale(fresh)
            print("\n".join([f"not fresh: {name}" for name in differing] or ["fresh"]))
            return 1 if differing else 0
        if PACKAGE.exists():
            shutil.rmtree(PACKAGE)
        shutil.copytree(fresh, PACKAGE)
    return 0


if __name__ == "__main__":
    sys.exit(main())
