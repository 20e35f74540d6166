# What the rest of graphnav takes of this folder, each imported on first use.

from .durations import Durations
from .engine import Engine, Outcome, Sink, Spans, seed_of
from .firing import Taken, Used
from .join import MatchedSet
from .live_inbox import LiveInbox
from .lockstep import Lockstep, LockstepEngine
from .recording.kept_messages import complete_channels
from .recording.log_forecast import size_text
from .recording.progress_file import ProgressFile
from .recording.recorded_run import Failures, Measured, RecordedRun
from .recording.run_recorded import LiveSink, about_of, new_run_id, run_recorded
from .recording.saved_graph import remember_copies
from .recording.stall import StallLimit
from .recording.summary import Summary
from .stage_calls import StageCalls
from .status import Rates, memory_mb
from .timer import Timer
from .unit import Unit

__all__ = [
    "Durations",
    "Engine",
    "Failures",
    "LiveInbox",
    "LiveSink",
    "Lockstep",
    "LockstepEngine",
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
    "memory_mb",
    "new_run_id",
    "remember_copies",
    "run_recorded",
    "seed_of",
    "size_text",
]
