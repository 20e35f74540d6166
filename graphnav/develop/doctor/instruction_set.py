"""Check that the logs of this machine are the same as on others."""

from __future__ import annotations

from graphnav.core.machine import OPT_OUT, PORTABLE, lacking, used_instruction_set
from graphnav.develop.doctor.finding import Finding

_SUBJECT = "instruction set"


def portable_logs() -> Finding:
    """Return what numpy, OpenCV and BLAS compute with, and whether that is the same on other machines."""
    found = used_instruction_set()
    if found == PORTABLE:
        return Finding(_SUBJECT, fine=True, seen=f"{found}: logs are the same on every machine that has them")
    if what := lacking():
        return Finding(_SUBJECT, fine=True, seen=f"{what}: logs are the same only on such CPUs")
    seen = f"{found}: logs are the same only on such CPUs"
    return Finding(_SUBJECT, fine=False, seen=seen, fix=f"unset {OPT_OUT}", needed=False)
