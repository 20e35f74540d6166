"""Tell what the user ends from what a plugin raises: Ctrl-C and SIGTERM have exceptions of their own."""

from __future__ import annotations


class CtrlC(KeyboardInterrupt):
    """The user ends the program by a signal; a plain KeyboardInterrupt out of a plugin is an error of the plugin."""


class Terminated(SystemExit):
    """SIGTERM or SIGHUP ends the program; any other SystemExit out of a plugin is an error of the plugin."""


USER_ENDS = (CtrlC, Terminated)
"""The exceptions that no handler of a plugin's errors may keep."""
