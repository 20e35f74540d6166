# What the rest of graphnav takes of this folder, each imported on first use.

from .camera_devices import CameraDevice, CameraMode, cameras
from .clock_words import NOTABLE_OFFSET_S, SET_ALIKE, offset_text, set_text, side_text, span_text
from .console import Console
from .cpu_quota import CpuQuota
from .escaped_streams import escaped_output
from .extras import import_extra, import_pandas, install_command, requirements_of
from .files import is_own, open_regular, path_aside, read_json, write_atomically
from .instruction_set import PORTABLE, environment_alike, expected_instruction_set, used_instruction_set
from .packet_filter import keep_channels
from .peer import peer_of
from .pins import OPT_OUT, lacking, pin
from .receive_buffer import ReceiveBuffer
from .system import is_linux, lock_file, open_file, require_linux, system_name
from .terminal_graphics import TerminalGraphics
from .threads import ONE_THREAD, end_despite_threads
from .user_folders import no_user_folder, user_folder

__all__ = [
    "NOTABLE_OFFSET_S",
    "ONE_THREAD",
    "OPT_OUT",
    "PORTABLE",
    "SET_ALIKE",
    "CameraDevice",
    "CameraMode",
    "Console",
    "CpuQuota",
    "ReceiveBuffer",
    "TerminalGraphics",
    "cameras",
    "end_despite_threads",
    "environment_alike",
    "escaped_output",
    "expected_instruction_set",
    "import_extra",
    "import_pandas",
    "install_command",
    "is_linux",
    "is_own",
    "keep_channels",
    "lacking",
    "lock_file",
    "no_user_folder",
    "offset_text",
    "open_file",
    "open_regular",
    "path_aside",
    "peer_of",
    "pin",
    "read_json",
    "require_linux",
    "requirements_of",
    "set_text",
    "side_text",
    "span_text",
    "system_name",
    "used_instruction_set",
    "user_folder",
    "write_atomically",
]
