"""Check this machine for LCM, a graph and the installed plugins; every problem has a command that fixes it."""

from graphnav.develop.doctor.finding import Finding
from graphnav.develop.doctor.run_checks import run_checks

__all__ = ["Finding", "run_checks"]
