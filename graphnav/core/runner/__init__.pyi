# What the rest of graphnav takes of this folder, each imported on first use.

from .durations import Durations
from .engine import Engine, Outcome, Sink, Spans, decoded, seed_of
from .firing import Taken, Used
from .join import MatchedSet
from .live_inbox import LiveInbox
from .lockstep import Lockstep, LockstepEngine
from .lockstep_inbox import LockstepInbox
from .recording.changes import Answer, Changes, Request, ask, giving_way, reset_stage
from .recording.full_log import LOOK_BYTES, is_nearly_full
from .recording.kept_messages import complete_channels
from .recording.log_forecast import size_text
from .recording.progress_file import ProgressFile
from .recording.provenance import CODE, Difference, difference, difference_here, files_of_graphs, provenance
from .recording.recorded_run import Failures, Measured, RecordedRun
from .recording.run_recorded import LiveSink, about_of, new_run_id, run_recorded
from .recording.running_file import RunningFile, RunningRun
from .recording.saved_graph import remember_copies
from .recording.stall import StallLimit
from .recording.summary import Summary
from .remote_unit import Done, Encoded, LiveStep, ProcessState, RemoteProcesses, RemoteStage, RemoteUnit
from .stage_calls import StageCalls
from .status import ProcessStatuses, Rates, edge_statuses, memory_mb
from .timer import ArrivalTimer, Timer
from .unit import LocalUnit, Unit

__all__ = [
    "CODE",
    "LOOK_BYTES",
    "Answer",
    "ArrivalTimer",
    "Changes",
    "Difference",
    "Done",
    "Durations",
    "Encoded",
    "Engine",
    "Failures",
    "LiveInbox",
    "LiveSink",
    "LiveStep",
    "LocalUnit",
    "Lockstep",
    "LockstepEngine",
    "LockstepInbox",
    "MatchedSet",
    "Measured",
    "Outcome",
    "ProcessState",
    "ProcessStatuses",
    "ProgressFile",
    "Rates",
    "RecordedRun",
    "RemoteProcesses",
    "RemoteStage",
    "RemoteUnit",
    "Request",
    "RunningFile",
    "RunningRun",
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
    "ask",
    "complete_channels",
    "decoded",
    "difference",
    "difference_here",
    "edge_statuses",
    "files_of_graphs",
    "giving_way",
    "is_nearly_full",
    "memory_mb",
    "new_run_id",
    "provenance",
    "remember_copies",
    "reset_stage",
    "run_recorded",
    "seed_of",
    "size_text",
]
