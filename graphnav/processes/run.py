"""Run a graph in the processes that it names, in lockstep or live."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack, closing
from pathlib import Path
from typing import Any

from graphnav import Graph, Stage
from graphnav.core.interrupts import Interrupt
from graphnav.core.notices import print_notice
from graphnav.core.runner import Lockstep, RemoteStage, Sink, Spans, StageCalls, Summary, run_recorded
from graphnav.processes.hosts import Host
from graphnav.processes.process_lockstep import ProcessLockstep
from graphnav.processes.process_stage import ProcessStage
from graphnav.processes.supervisor import Supervisor


def run_processes(
    graph: Graph,
    stages: dict[str, Stage],
    folder: Path,
    *,
    notice: Callable[[str], None] = print_notice,
    supervised: Callable[[Supervisor], None] = lambda _: None,
    hosts: Mapping[str, Host] | None = None,
    **options: Any,
) -> Summary:
    """Run ``graph`` once into ``folder`` as `run_recorded` does, with the stages of `Graph.deploy` in their processes.

    The log has the same bytes as that of one process. ``stages``: those that no process names are stepped here.
    ``notice`` also gets restarts, and what stages of other processes print. ``supervised`` gets the supervisor before
    the processes start. ``hosts``: as of `Supervisor`. ``options``: of `run_recorded`.

    Raises
    ------
    GraphnavError
        The processes cannot be connected.
    UserError
        The folder cannot be written.
    CtrlC
        The user asked for the end before the stages were wired, or after the run had reached its own.
    """
    with closing(Supervisor(graph, folder.absolute(), notice, hosts=hosts)) as supervisor:
        supervised(supervisor)

        def make_lockstep(
            graph: Graph,
            stages: Mapping[str, Stage],
            sinks: Sequence[Sink],
            spans: Spans | None,
            calls: StageCalls,
            interrupt: Interrupt,
        ) -> Lockstep:
            supervisor.is_asked_to_stop = lambda: interrupt.asked
            supervisor.start()
            return ProcessLockstep(graph, {**stages, **_stages_of(supervisor)}, sinks, spans, calls, supervisor)

        return run_recorded(graph, stages, folder, notice=notice, make_lockstep=make_lockstep, **options)


def run_live_processes(
    run_live: Callable[..., Summary],
    graph: Graph,
    stages: dict[str, Stage],
    folder: Path,
    *,
    notice: Callable[[str], None] = print_notice,
    supervised: Callable[[Supervisor], None] = lambda _: None,
    hosts: Mapping[str, Host] | None = None,
    **options: Any,
) -> Summary:
    """Run ``graph`` live by ``run_live``, with the stages of `Graph.deploy` in their processes.

    ``notice``, ``supervised`` and ``hosts``: as of `run_processes`. ``options``: of ``run_live``.

    Raises
    ------
    GraphnavError
        The processes cannot be connected.
    UserError
        The folder cannot be written, or a log to play does not contain the channels of the graph.
    CtrlC
        The user asked for the end before the stages were wired, or after the run had reached its own.
    """
    with ExitStack() as cleanup:

        def start(interrupt: Interrupt) -> tuple[Supervisor, Mapping[str, RemoteStage]]:
            supervisor = Supervisor(graph, folder.absolute(), notice, is_live=True, hosts=hosts)
            cleanup.enter_context(closing(supervisor))
            supervisor.is_asked_to_stop = lambda: interrupt.asked
            supervised(supervisor)
            supervisor.start()
            supervisor.await_ready()
            return supervisor, _stages_of(supervisor)

        return run_live(graph, stages, folder, notice=notice, start_processes=start, **options)


def _stages_of(supervisor: Supervisor) -> Mapping[str, RemoteStage]:
    return {
        node.name: ProcessStage(process, place, supervisor)
        for process in supervisor.processes.values()
        for place, node in enumerate(process.nodes)
    }
