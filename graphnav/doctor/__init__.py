"""What this machine lacks for LCM, for a graph and for the installed plugins, with the commands that fix it."""

from graphnav.doctor.examine import examine
from graphnav.doctor.finding import Finding

__all__ = ["Finding", "examine"]
