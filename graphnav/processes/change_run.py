"""Change a running run from the command line, and tell what became of it."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from typing import Literal

from graphnav import Place, Problem, UserError
from graphnav.core.cli import Exit
from graphnav.core.graph import Override
from graphnav.core.runner import Request, ask
from graphnav.processes.running_runs import run_named

_COMMANDS = {"setting": "set", "stage": "swap"}
_HINTS = {
    "setting": "write STAGE.PARAMETER=VALUE; 'graphnav swap' swaps stages",
    "stage": "write STAGE=FAMILY.STAGE; --set gives parameters and wires of the new stage",
}


def change_run(
    name: str | None,
    *,
    overrides: Sequence[str] = (),
    kind: Literal["setting", "stage"] = "setting",
    settings: Sequence[str] = (),
    restart: str = "",
) -> int:
    """Ask a run, the only one if it is not named, for a change; print when it took over; return the exit status.

    ``overrides``: of this ``kind``. ``settings``: those of ``--set``. ``restart``: a stage to be rebuilt.

    Raises
    ------
    UserError
        No run has this name, or it refuses the change.
    """
    problems: list[Problem] = []
    for text in overrides:
        try:
            if Override.parse(text, Place(text)).target.kind != kind:
                problems.append(
                    Problem(Place(text), f"this is not what 'graphnav {_COMMANDS[kind]}' changes", _HINTS[kind])
                )
        except UserError as error:
            problems += error.problems
    if problems:
        raise UserError(problems)
    run = run_named(name)
    words = (*overrides, *(f"--set {text}" for text in settings))
    answer = ask(run, Request(words, restart, os.getcwd()), lambda: print("waiting for the run", file=sys.stderr))
    for notice in answer.notices:
        print(notice)
    if answer.problems:
        raise UserError(answer.problems)
    what = f"stage '{restart}' is rebuilt" if restart else ", ".join((*overrides, *settings))
    if answer.at_s is None:
        print(f"run {run.run_id} has ended: nothing was changed", file=sys.stderr)
        return Exit.FAILED
    print(f"run {run.run_id}: {what} from {answer.at_s:.2f} s on")
    return Exit.OK
