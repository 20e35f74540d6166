"""Ctrl-C and SIGTERM by the user, and code of plugins that may raise the same."""

from graphnav.core.interrupts.ctrl_c import ctrl_c_later, ctrl_c_not_lost, plain_ctrl_c, raise_ctrl_c
from graphnav.core.interrupts.third_party import third_party_code, working_folder_restored
from graphnav.core.interrupts.user_ends import USER_ENDS, CtrlC, Terminated

__all__ = [
    "USER_ENDS",
    "CtrlC",
    "Terminated",
    "ctrl_c_later",
    "ctrl_c_not_lost",
    "plain_ctrl_c",
    "raise_ctrl_c",
    "third_party_code",
    "working_folder_restored",
]
