"""The runner: owns stages and bus, and applies the firing rule."""

from graphnav.runner.lockstep import Outcome, Runner
from graphnav.runner.seeds import seed_of

__all__ = ["Outcome", "Runner", "seed_of"]
