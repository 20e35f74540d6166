# What the rest of graphnav takes of this folder, each imported on first use.

from .atomic_write import path_aside, write_atomically
from .console import Console
from .escaped_streams import escaped_output
from .extras import import_pandas, install_command, requirements_of
from .instruction_set import PORTABLE, expected_instruction_set, used_instruction_set
from .jdk import find_jdk, install_jdk, require_jdk
from .leftover_threads import end_despite_threads
from .packet_filter import keep_channels
from .pins import OPT_OUT, lacking, pin
from .receive_buffer import (
    RECEIVE_BUFFER_BYTES,
    ReceiveBuffer,
    buffer_limit,
    larger_buffer,
    needed_buffer,
    try_receive_buffer,
)
from .regular_file import is_own, read_json
from .single_thread import ONE_THREAD
from .terminal_graphics import CellSize, TerminalGraphics, cell_size_px, query_terminal
from .user_folders import user_folder

__all__ = [
    "ONE_THREAD",
    "OPT_OUT",
    "PORTABLE",
    "RECEIVE_BUFFER_BYTES",
    "CellSize",
    "Console",
    "ReceiveBuffer",
    "TerminalGraphics",
    "buffer_limit",
    "cell_size_px",
    "end_despite_threads",
    "escaped_output",
    "expected_instruction_set",
    "find_jdk",
    "import_pandas",
    "install_command",
    "install_jdk",
    "is_own",
    "keep_channels",
    "lacking",
    "larger_buffer",
    "needed_buffer",
    "path_aside",
    "pin",
    "query_terminal",
    "read_json",
    "require_jdk",
    "requirements_of",
    "try_receive_buffer",
    "used_instruction_set",
    "user_folder",
    "write_atomically",
]
