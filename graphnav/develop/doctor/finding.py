"""The result of one check."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Finding:
    """The result of a check: the subject, whether it is fine, the observation, and the command that fixes it.

    ``needed``: whether graphnav requires it; otherwise it is an extra.
    """

    subject: str
    fine: bool
    seen: str
    fix: str = ""
    needed: bool = True
