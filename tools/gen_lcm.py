"""Generate the Python of all *.lcm files with the wheel's lcm-gen; --check tests whether it is up to date."""

from __future__ import annotations

import argparse
import re
import shutil
import subprocess
import sys
import sysconfig
import tempfile
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parent.parent


class Target(NamedTuple):
    """A folder of type definitions and the package generated from them; ``prefix``: its parent package.

    The definitions are copied beside the Python, so that they are in the wheel.
    """

    types: Path
    package: Path
    prefix: str = ""

    def generate(self, folder: Path) -> Path:
        """Run lcm-gen on every type definition; return the package generated in ``folder``."""
        command = [str(Path(sysconfig.get_path("scripts")) / "lcm-gen"), "-p", "--ppath", str(folder)]
        prefix = ["--package-prefix", self.prefix] if self.prefix else []
        definitions = sorted(self.types.glob("*.lcm"))
        subprocess.run([*command, *prefix, *map(str, definitions)], check=True)
        made = folder.joinpath(*self.prefix.split("."), self.package.name)
        for definition in definitions:
            shutil.copy(definition, made)
        return made

    def stale(self, fresh: Path) -> list[str]:
        """Return the names of files that differ between the package and a newly generated one."""
        found = (path for folder in (self.package, fresh) for path in folder.iterdir())
        names = {path.name for path in found if path.suffix in {".py", ".lcm"}}
        return sorted(name for name in names if _text(self.package / name) != _text(fresh / name))


BOT_CORE = ROOT / "plugins/graphnav_adapters/lcmtypes/bot_core"
TARGETS = (
    Target(ROOT / "lcmtypes", ROOT / "lcmtypes/graphnav_lcm"),
    Target(BOT_CORE, BOT_CORE, "graphnav_adapters.lcmtypes"),
)
"""Third-party types are generated inside the plugin: their own packages may be installed too."""


def _text(path: Path) -> str | None:
    """Return a generated file without the version of lcm-gen, None if there is no such file."""
    return re.sub(r"^lcm-gen [\d.]+$", "", path.read_text(), flags=re.MULTILINE) if path.exists() else None


def main() -> int:
    """Generate, or with --check compare; return 1 if something differs."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--check", action="store_true", help="change nothing, return 1 if a file is out of date")
    args = parser.parse_args()
    differing: list[str] = []
    for target in TARGETS:
        with tempfile.TemporaryDirectory() as scratch:
            fresh = target.generate(Path(scratch))
            if args.check:
                differing += [f"not fresh: {target.package.name}/{name}" for name in target.stale(fresh)]
                continue
            for name in target.stale(fresh):
                (target.package / name).unlink(missing_ok=True)
            shutil.copytree(fresh, target.package, dirs_exist_ok=True)
    if args.check:
        print("\n".join(differing or ["fresh"]))
    return 1 if differing else 0


if __name__ == "__main__":
    sys.exit(main())
