"""``graphnav completion``: the script that makes a shell complete the command line."""

from __future__ import annotations

import argparse
import sys

from graphnav.core.parameters import Parameter, command
from graphnav.develop.completion import SHELLS, shell_script

_EXAMPLES = """\
put one of these into ~/.bashrc, ~/.zshrc (below compinit) or ~/.config/fish/config.fish:
  source <(graphnav completion bash)
  source <(graphnav completion zsh)
  graphnav completion fish | source"""


@command(Parameter("shell", metavar="SHELL", choices=SHELLS, help="bash, zsh or fish"), examples=_EXAMPLES)
def main(args: argparse.Namespace) -> int:
    """Print the script."""
    sys.stdout.write(shell_script(args.shell))
    return 0
