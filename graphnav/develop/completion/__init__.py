"""Tab completion of the command line."""

from graphnav.develop.completion.complete import complete, completed_command, completer
from graphnav.develop.completion.shell_script import SHELLS, shell_script

__all__ = ["SHELLS", "complete", "completed_command", "completer", "shell_script"]
