# What the rest of graphnav takes of this folder, each imported on first use.

from .durations import Durations
from .engine import Engine, Outcome, Sink, Spans, seed_of
from .firing import Taken, Used
from .join import MAX_UNMATCHED, MatchedSet
from .live_inbox import LiveInbox
from .lockstep import Lockstep, fire, fire_complete
from .lockstep_inbox import LockstepInbox
from .recording.kept_messages import complete_channels
from .recording.log_forecast import size_text
from .recording.progress_file import ProgressFile
from .recording.recorded_run import Failures, Measured, RecordedRun
from .recording.run_recorded import LiveSink, about_of, new_run_id, run_recorded
from .recording.saved_graph import copies_of
from .recording.stall import StallLimit
from .recording.summary import Summary
from .stage_calls import StageCalls
from .status import Rates, memory_mb
from .timer import Timer
from .unit import Unit

__all__ = [
    "MAX_UNMATCHED",
    "Durations",
    "Engine",
    "Failures",
    "LiveInbox",
    "LiveSink",
    "Lockstep",
    "LockstepInbox",
    "MatchedSet",
    "Measured",
    "Outcome",
    "ProgressFile",
    "Rates",
    "RecordedRun",
    "Sink",
    "Spans",
    "StageCalls",
    "StallLimit",
    "Summary",
    "Taken",
    "Timer",
    "Unit",
    "Used",
    "about_of",
    "complete_channels",
    "copies_of",
    "fire",
    "fire_complete",
    "memory_mb",
    "new_run_id",
    "run_recorded",
    "seed_of",
    "size_text",
]
