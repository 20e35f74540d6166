"""Measure where the time of a tick goes: by stage, by channel, and beside the sum of the steps alone."""

from graphnav.develop.profiling.measurement import NothingMeasuredError, measure, refuse_live
from graphnav.develop.profiling.profile import Profile
from graphnav.develop.profiling.step_functions import functions_missing
from graphnav.develop.profiling.text import print_profile

__all__ = ["NothingMeasuredError", "Profile", "functions_missing", "measure", "print_profile", "refuse_live"]
