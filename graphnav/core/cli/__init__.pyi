# What the rest of graphnav takes of this folder, each imported on first use.

from .command_arguments import CommandArguments
from .command_line import COMMANDS, command_called, commands, main
from .opened_log import damage_told, opened
from .options import FailureReport, Options
from .progress import progress_bar
from .quantities import MAX_FACTOR, channel_name, counted, port_number, positive
from .run import run_graph
from .status import Exit
from .status_line import StatusLine
from .type_names import short_type

__all__ = [
    "COMMANDS",
    "MAX_FACTOR",
    "CommandArguments",
    "Exit",
    "FailureReport",
    "Options",
    "StatusLine",
    "channel_name",
    "command_called",
    "commands",
    "counted",
    "damage_told",
    "main",
    "opened",
    "port_number",
    "positive",
    "progress_bar",
    "run_graph",
    "short_type",
]
