"""Check the programs that graphnav uses: LCM's wheel, Java."""

from __future__ import annotations

import subprocess
from importlib.metadata import PackageNotFoundError, requires, version

from packaging.requirements import Requirement

from graphnav.develop.doctor.finding import Finding
from graphnav.develop.jdk import find_jdk, install_jdk

_TIMEOUT_S = 20.0


def lcm_wheel() -> Finding:
    """Check the installed LCM."""
    needed = next(one for one in map(Requirement, requires("graphnav") or ()) if one.name == "lcm")
    fix = f"pip install --upgrade '{needed}'"
    try:
        found = version("lcm")
    except PackageNotFoundError:
        return Finding("lcm", fine=False, seen="not installed", fix=fix)
    if not needed.specifier.contains(found, prereleases=True):
        return Finding("lcm", fine=False, seen=f"version {found}, but {needed.specifier} is needed", fix=fix)
    return Finding("lcm", fine=True, seen=f"version {found}")


def java() -> Finding:
    """Check for the JDK that lcm-spy and jars of types need."""
    jdk = find_jdk()
    if jdk.missing or jdk.java is None:
        seen = f"{jdk.missing}; 'graphnav lcm-spy' needs a JDK"
        return Finding("java", fine=False, seen=seen, fix=install_jdk(), needed=False)
    try:
        done = subprocess.run(  # noqa: S603, found on the user's path
            [jdk.java, "-version"], capture_output=True, text=True, timeout=_TIMEOUT_S, check=True
        )
    except (OSError, subprocess.SubprocessError) as error:
        return Finding("java", fine=False, seen=f"it does not run: {error}", fix=install_jdk(), needed=False)
    lines = (done.stderr or done.stdout).strip().splitlines()
    return Finding("java", fine=True, seen=lines[0] if lines else str(jdk.java))
