# What the rest of graphnav takes of this folder, each imported on first use.

from .durations import Durations
from .engine import Decode, Encode, Engine, Fire, Outcome, Sink, Spans, seed_of
from .firing import Taken, Used, encoded_firing
from .join import MAX_UNMATCHED, MatchedSet
from .live_inbox import LiveInbox
from .lockstep import Lockstep, command_channels, fire, fire_complete
from .lockstep_inbox import LockstepInbox
from .recording.kept_messages import ChannelsExcept, complete_channels, kept, open_log, reproducible_channels
from .recording.log_forecast import size_text
from .recording.progress_file import ProgressFile
from .recording.recorded_run import Failures, Measured, RecordedRun
from .recording.run_recorded import LiveSink, about_of, live_about, new_run_id, run_recorded
from .recording.saved_graph import copies_of, save_graph
from .recording.stall import StallLimit
from .recording.summary import Summary
from .stage_calls import StageCalls
from .status import Rates, memory_mb
from .timer import Timer
from .unit import Publish, Unit

__all__ = [
    "MAX_UNMATCHED",
    "ChannelsExcept",
    "Decode",
    "Durations",
    "Encode",
    "Engine",
    "Failures",
    "Fire",
    "LiveInbox",
    "LiveSink",
    "Lockstep",
    "LockstepInbox",
    "MatchedSet",
    "Measured",
    "Outcome",
    "ProgressFile",
    "Publish",
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
    "command_channels",
    "complete_channels",
    "copies_of",
    "encoded_firing",
    "fire",
    "fire_complete",
    "kept",
    "live_about",
    "memory_mb",
    "new_run_id",
    "open_log",
    "reproducible_channels",
    "run_recorded",
    "save_graph",
    "seed_of",
    "size_text",
]
