# What the rest of graphnav takes of this folder, each imported on first use.

from .command_line import COMMANDS, command_called, commands, main
from .opened_log import damage_told, opened
from .options import FailureReport, Options, catalog_of, load, load_types_of, notices_of, overrides_of, url_of
from .progress import progress_bar
from .quantities import MAX_FACTOR, channel_name, counted, positive
from .status import Exit
from .status_line import StatusLine
from .trust import trust_of
from .type_names import listed_types, short_type, type_called

__all__ = [
    "COMMANDS",
    "MAX_FACTOR",
    "Exit",
    "FailureReport",
    "Options",
    "StatusLine",
    "catalog_of",
    "channel_name",
    "command_called",
    "commands",
    "counted",
    "damage_told",
    "listed_types",
    "load",
    "load_types_of",
    "main",
    "notices_of",
    "opened",
    "overrides_of",
    "positive",
    "progress_bar",
    "short_type",
    "trust_of",
    "type_called",
    "url_of",
]
