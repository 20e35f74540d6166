# What the rest of graphnav takes of this folder, each imported on first use.

from .console import Console
from .escaped_streams import escaped_output
from .extras import import_extra, import_pandas, install_command, requirements_of
from .files import is_own, open_regular, path_aside, read_json, write_atomically
from .instruction_set import PORTABLE, environment_alike, expected_instruction_set, used_instruction_set
from .packet_filter import keep_channels
from .peer import peer_of
from .pins import OPT_OUT, lacking, pin
from .receive_buffer import ReceiveBuffer
from .terminal_graphics import TerminalGraphics
from .threads import ONE_THREAD, end_despite_threads
from .user_folders import no_user_folder, user_folder

__all__ = [
    "ONE_THREAD",
    "OPT_OUT",
    "PORTABLE",
    "Console",
    "ReceiveBuffer",
    "TerminalGraphics",
    "end_despite_threads",
    "environment_alike",
    "escaped_output",
    "expected_instruction_set",
    "import_extra",
    "import_pandas",
    "install_command",
    "is_own",
    "keep_channels",
    "lacking",
    "no_user_folder",
    "open_regular",
    "path_aside",
    "peer_of",
    "pin",
    "read_json",
    "requirements_of",
    "used_instruction_set",
    "user_folder",
    "write_atomically",
]
