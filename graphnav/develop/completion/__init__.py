"""Tab completion of the command line."""

from graphnav.develop.completion.complete import SHELLS, complete, completed_command, completer, shell_script

__all__ = ["SHELLS", "complete", "completed_command", "completer", "shell_script"]
