"""What this machine lacks for LCM, for a graph and for the installed plugins, with the commands that fix it."""

from graphnav.doctor.finding import Finding
from graphnav.doctor.run_checks import run_checks

__all__ = ["Finding", "run_checks"]
