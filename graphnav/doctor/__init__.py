"""Check this machine for LCM, a graph and the installed plugins; every problem has a command that fixes it."""

from graphnav.doctor.finding import Finding
from graphnav.doctor.run_checks import run_checks

__all__ = ["Finding", "run_checks"]
