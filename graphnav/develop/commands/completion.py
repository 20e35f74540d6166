"""``graphnav completion``: the script that makes a shell complete the command line."""

from __future__ import annotations

import argparse
import sys

from graphnav.develop.completion import SHELLS, shell_script

_EXAMPLES = """\
put one of these into ~/.bashrc, ~/.zshrc (below compinit) or ~/.config/fish/config.fish:
  source <(graphnav completion bash)
  source <(graphnav completion zsh)
  graphnav completion fish | source"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.epilog = _EXAMPLES
    parser.add_argument("shell", metavar="SHELL", choices=SHELLS, help="bash, zsh or fish")


def main(args: argparse.Namespace) -> int:
    """Print the script."""
    sys.stdout.write(shell_script(args.shell))
    return 0
