"""Check what is installed: LCM, Java, extras, plugins, and what this machine computes and draws with."""

from __future__ import annotations

import subprocess
from collections.abc import Iterator
from importlib.metadata import PackageNotFoundError, metadata, requires, version

from packaging.requirements import Requirement

from graphnav.core.catalog import Catalog
from graphnav.core.errors import CatalogError
from graphnav.core.machine import (
    OPT_OUT,
    PORTABLE,
    TerminalGraphics,
    install_command,
    lacking,
    requirements_of,
    used_instruction_set,
)
from graphnav.develop.doctor.finding import Finding
from graphnav.develop.java import find_jdk, install_jdk

_TIMEOUT_S = 20.0
_OF_DEVELOPERS = {"dev"}


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


def portable_logs() -> Finding:
    """Return what numpy, OpenCV and BLAS compute with, and whether that is the same on other machines."""
    found = used_instruction_set()
    if found == PORTABLE:
        return Finding("instruction set", fine=True, seen=f"{found}: logs are the same on every machine that has them")
    if what := lacking():
        return Finding("instruction set", fine=True, seen=f"{what}: logs are the same only on such CPUs")
    seen = f"{found}: logs are the same only on such CPUs"
    return Finding("instruction set", fine=False, seen=seen, fix=f"unset {OPT_OUT}", needed=False)


def terminal_graphics() -> Finding:
    """Query the terminal, if this program runs in one."""
    graphics = TerminalGraphics.query()
    if graphics is None:
        return Finding("terminal graphics", fine=True, seen="not checked: not a terminal")
    confirmed = [name for name, is_so in (("kitty", graphics.kitty), ("sixel", graphics.sixel)) if is_so]
    seen = ", ".join([*confirmed, "half blocks"])
    return Finding("terminal graphics", fine=True, seen=f"{seen}; {graphics.failure}" if graphics.failure else seen)


def extras() -> Iterator[Finding]:
    """Check each extra that graphnav's package declares."""
    for extra in sorted(set(metadata("graphnav").get_all("Provides-Extra") or ()) - _OF_DEVELOPERS):
        own = requirements_of(extra)
        problems = [problem for one in own if (problem := _missing(one))]
        seen = "; ".join(problems) or ", ".join(f"{one.name} {version(one.name)}" for one in own)
        fix = install_command(extra) if problems else ""
        yield Finding(f"extra {extra}", fine=not problems, seen=seen, fix=fix, needed=False)


def _missing(needed: Requirement) -> str:
    try:
        found = version(needed.name)
    except PackageNotFoundError:
        return f"{needed.name} is not installed"
    return (
        "" if needed.specifier.contains(found, prereleases=True) else f"{needed.name} {found} is not {needed.specifier}"
    )


def families() -> Iterator[Finding]:
    """Import every family of stages."""
    catalog = Catalog()
    for family in catalog.families():
        try:
            names = catalog.names(family)
        except CatalogError as error:
            yield Finding(
                f"family {family}", fine=False, seen=error.what, fix=str(error.hint) or "reinstall its package"
            )
        else:
            yield Finding(f"family {family}", fine=True, seen=", ".join(names) or "no stages")
