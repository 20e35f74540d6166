"""What the doctor says of one thing."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Finding:
    """One thing that was looked at: whether it is fine, what was seen, and the command that fixes it.

    ``needed``: whether graphnav lacks something without it; else it is an extra.
    """

    subject: str
    fine: bool
    seen: str
    fix: str = ""
    needed: bool = True
