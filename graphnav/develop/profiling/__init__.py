"""Measure where the time of a tick goes: by stage, by channel, and beside the sum of the steps alone."""

from graphnav.develop.profiling.fit import Fit, measure_fit
from graphnav.develop.profiling.measurement import NothingMeasuredError, measure, refuse_live
from graphnav.develop.profiling.profile import Profile, print_profile
from graphnav.develop.profiling.step_functions import functions_missing

__all__ = [
    "Fit",
    "NothingMeasuredError",
    "Profile",
    "functions_missing",
    "measure",
    "measure_fit",
    "print_profile",
    "refuse_live",
]
