"""Run all checks of CI in order: format, lint, types, architecture, docs, tests."""

from __future__ import annotations

import os
import subprocess
import sys
import sysconfig
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
SCRIPTS = Path(sysconfig.get_path("scripts"))
CHECKED = ["graphnav", "plugins", "tests", "tools", "docs/conf.py"]
WORKERS = 2 * (os.cpu_count() or 1)
"""Processes of the tests: live ones mostly wait for what others send, so that two share a core."""

STEPS: dict[str, list[str]] = {
    "format": [sys.executable, "-m", "ruff", "format", "--check", "--quiet", *CHECKED],
    "lint": [sys.executable, "-m", "ruff", "check", "--quiet", *CHECKED],
    "types": [sys.executable, "-m", "mypy", *CHECKED],
    "architecture": [str(SCRIPTS / "lint-imports"), "--no-logo"],
    "docs": [
        sys.executable,
        "-m",
        "sphinx",
        "-W",
        "--keep-going",
        "--nitpicky",
        "--quiet",
        "--fresh-env",
        "docs",
        "build/docs",
    ],
    "tests": [sys.executable, "-m", "pytest", "-q", "-n", str(WORKERS), "--dist", "worksteal"],
}


def main() -> int:
    """Run the steps named on the command line, else all; return 1 if one failed."""
    wanted = sys.argv[1:] or list(STEPS)
    if unknown := [name for name in wanted if name not in STEPS]:
        print(f"no step {', '.join(unknown)}: steps are {', '.join(STEPS)}", file=sys.stderr)
        return 2
    failed = []
    for name in wanted:
        print(f"== {name}", flush=True)
        begin = time.monotonic()
        if subprocess.run(STEPS[name], cwd=ROOT, check=False).returncode:
            failed.append(name)
        print(f"== {name}: {'FAILED' if name in failed else 'ok'}, {time.monotonic() - begin:.0f} s", flush=True)
    print(f"failed: {', '.join(failed)}" if failed else "all ok")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
