"""Check the optional dependencies (extras) of graphnav."""

from __future__ import annotations

from collections.abc import Iterator
from importlib.metadata import PackageNotFoundError, metadata, version

from packaging.requirements import Requirement

from graphnav.core.machine import install_command, requirements_of
from graphnav.develop.doctor.finding import Finding

_OF_DEVELOPERS = {"dev"}


def extras() -> Iterator[Finding]:
    """Check each extra that graphnav's package declares."""
    for extra in sorted(set(metadata("graphnav").get_all("Provides-Extra") or ()) - _OF_DEVELOPERS):
        own = requirements_of(extra)
        problems = [problem for one in own if (problem := _problem(one))]
        seen = "; ".join(problems) or ", ".join(f"{one.name} {version(one.name)}" for one in own)
        fix = install_command(extra) if problems else ""
        yield Finding(f"extra {extra}", fine=not problems, seen=seen, fix=fix, needed=False)


def _problem(needed: Requirement) -> str:
    try:
        found = version(needed.name)
    except PackageNotFoundError:
        return f"{needed.name} is not installed"
    return (
        "" if needed.specifier.contains(found, prereleases=True) else f"{needed.name} {found} is not {needed.specifier}"
    )
