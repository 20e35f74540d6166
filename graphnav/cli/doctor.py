"""``graphnav doctor``: say what this machine lacks."""

from __future__ import annotations

import argparse

from graphnav.cli.status import FAILED, OK


def add_arguments(_parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments: it has none."""


def main(_args: argparse.Namespace) -> int:
    """Run the command; the exit status is 1 where something is lacking."""
    from rich.console import Console  # noqa: PLC0415
    from rich.markup import escape  # noqa: PLC0415

    from graphnav.doctor import examine  # noqa: PLC0415

    console = Console(highlight=False, soft_wrap=True)
    lacking = 0
    for finding in examine():
        mark = "[green]ok  [/]" if finding.fine else "[red]MEND[/]"
        console.print(f"{mark} {finding.subject}: {escape(finding.seen)}")
        if not finding.fine:
            lacking += 1
            if finding.mend:
                console.print(f"     {escape(finding.mend)}")
    return FAILED if lacking else OK
