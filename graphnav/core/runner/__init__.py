"""The engine that runs graphs, and the schedule of lockstep."""

from graphnav.core.runner.engine import Outcome, seed_of
from graphnav.core.runner.lockstep import Lockstep

__all__ = ["Lockstep", "Outcome", "seed_of"]
