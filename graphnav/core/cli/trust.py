"""``graphnav trust``: the folders whose plugin files may run when their graphs are read; ask for more of them."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from graphnav.core.cli.status import Exit
from graphnav.core.errors import GraphnavError, UserError, shown_name, shown_path
from graphnav.core.notices import print_notice
from graphnav.core.parameters import Parameter, command, flag

if TYPE_CHECKING:
    from graphnav.core.trust import Request, Trust


@command(
    Parameter(
        "folder",
        nargs="?",
        type=Path,
        metavar="FOLDER",
        help="let the plugin files that graphs in this folder name run (default: list the folders)",
    ),
    flag("revoke", "--revoke", "ask again before anything of FOLDER runs"),
)
def main(args: argparse.Namespace) -> int:
    """Run the command."""
    from graphnav.core.trust import Request, forget, trusted_folders

    if args.folder is None:
        if args.revoke:
            raise UserError.of("--revoke needs a folder", "graphnav trust lists those that are trusted")
        for folder in trusted_folders():
            print(shown_name(folder))
        return Exit.OK
    folder = args.folder.resolve()
    is_known, name = str(folder) in trusted_folders(), shown_name(str(folder))
    if args.revoke:
        if not is_known:
            raise UserError.of(f"{args.folder} is not trusted", "graphnav trust lists the folders that are")
        why = forget(folder)
        done = f"no longer trusted: {name}; a plugin file that a graph in it names runs only after you were asked"
    elif folder.is_dir():
        why = Request(folder, ()).remember()
        done = f"{'already ' * is_known}trusted: {name}; plugin files that graphs in it name run without a question"
    else:
        raise UserError.of(f"{args.folder} is not a folder", "name the folder of a graph")
    if why:
        raise GraphnavError(f"the list of trusted folders is unchanged: {why}")
    print(done)
    return Exit.OK


def trust_of(args: argparse.Namespace, *, runs_all: bool = False) -> Trust:
    """Return which plugin files may run: all with ``--trust`` and for commands that run what the user names.

    Else those that are trusted; at a terminal the user is asked about others.
    """
    from graphnav.core.trust import Trust

    is_terminal = all(stream is not None and stream.isatty() for stream in (sys.stdin, sys.stderr))
    return Trust(
        runs_all=runs_all or getattr(args, "trust", False),
        ask=_ask if is_terminal else None,
        hint="run it with --trust",
        folder_hint=", or trust the folder: graphnav trust {folder}",
    )


def _ask(request: Request) -> bool:
    """Ask at the terminal whether plugin files may run."""
    print_notice(f"{shown_path(request.folder)} brings Python code that you have not trusted yet:")
    for file in request.files:
        print_notice(f"  {shown_path(file)}")
    print_notice("It would run with your rights: it can read, change and send all that you can.")
    lasts = "until a file of it changes" if request.digest else "for this folder, also for what is added to it"
    print(f"Run it? The answer yes is remembered {lasts}. [y/N] ", end="", file=sys.stderr, flush=True)
    return sys.stdin.readline().strip().lower() in {"y", "yes"}
