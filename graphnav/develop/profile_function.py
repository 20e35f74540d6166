"""``graphnav.profile``: measure where the time of a tick goes, from Python."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from graphnav import Graph, UserError
from graphnav.core.api import (
    Argument,
    KeptFolder,
    PathLike,
    Shared,
    TapMode,
    loaded,
    one_thread,
    tell,
)
from graphnav.core.catalog import Catalog
from graphnav.core.parameters import documented
from graphnav.core.runner import Outcome, new_run_id
from graphnav.core.tap import open_tap
from graphnav.core.trust import Trust
from graphnav.develop.parameters import CLOCK, FUNCTIONS, Clock
from graphnav.develop.profiling import NothingMeasuredError, Profile, functions_missing, measure, refuse_live


@documented(*Shared.OF_RUN, CLOCK, FUNCTIONS)
def profile(
    graph: PathLike | Graph,
    *,
    set: Mapping[str, object] | None = None,  # noqa: A002 - as --set
    seed: int | None = None,
    until_s: float | None = None,
    folder: PathLike | None = None,
    plugins: Sequence[PathLike] = (),
    tap: TapMode = "none",
    clock: Clock = "wall",
    functions: bool = False,
    trust: bool = False,
) -> Profile:
    """Run a graph in lockstep, with its log, and return where the time of its ticks went.

    ``print(profile)`` shows tables, a notebook the flame graph. A run that fails does not raise: `Profile.failure`
    says why, and the times are those of the ticks before.

    Raises
    ------
    UserError
        All errors of the graph and the arguments, or the graph has live inputs; nothing has run then.
    GraphnavError
        The run ended before a tick was measured.
    KeyboardInterrupt
        Ctrl-C, or a notebook's stop button, ended the run.
    """
    Argument(tap, Shared.TAP).check_choice()
    Argument(clock, CLOCK).check_choice()
    options = {"seed": seed, "until_s": until_s}
    checked = loaded(graph, set, plugins, Catalog(Trust(runs_all=trust)), options)
    refuse_live(checked)
    if functions and (missing := functions_missing()):
        raise UserError(missing)
    found = _measured(checked, folder, tap, clock, functions=functions)
    if found.outcome == Outcome.STOPPED:
        raise KeyboardInterrupt
    if found.failure:
        tell(f"the run failed: {found.failure}")
    return found


def _measured(graph: Graph, folder: PathLike | None, tap: TapMode, clock: Clock, *, functions: bool) -> Profile:
    stages = graph.make_stages()
    kept = KeptFolder.new(folder)
    run_id = new_run_id()
    try:
        with one_thread():
            return measure(
                graph,
                stages,
                kept.path,
                functions=functions,
                clock=clock,
                tap=open_tap(tap, run_id, tell=tell),
                run_id=run_id,
                notice=tell,
            )
    except NothingMeasuredError as error:
        if error.outcome == Outcome.STOPPED:
            raise KeyboardInterrupt from error
        raise
