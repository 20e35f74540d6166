"""Measure where the time of a tick goes: by stage, by channel, and beside the sum of the steps alone."""

from graphnav.profiling.measure import NothingMeasuredError, measure, refuse_live
from graphnav.profiling.profile import Profile
from graphnav.profiling.step_functions import functions_missing
from graphnav.profiling.text import print_profile

__all__ = ["NothingMeasuredError", "Profile", "functions_missing", "measure", "print_profile", "refuse_live"]
