"""The script that makes a shell ask graphnav for completions."""

from __future__ import annotations

SHELLS = ("bash", "zsh", "fish")


def shell_script(shell: str, program: str = "graphnav") -> str:
    """Return what one of `SHELLS` has to evaluate so that TAB completes the command line of ``program``."""
    from argcomplete.shell_integration import shellcode

    return shellcode([program], shell=shell).strip() + "\n"
