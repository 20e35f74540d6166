"""``graphnav up``: start the hosts of a graph over ssh, run it here, and end all together."""

from __future__ import annotations

from graphnav.core.cli import CommandArguments, Exit, command_called
from graphnav.core.parameters import OneOf, command

_OF_ONE_COMPUTER = {"host", "key"}
_ABOUT = """\
Runs 'graphnav run GRAPH --host NAME' on every host of the graph's 'deploy', with --set and --plugin as they are here,
and 'graphnav run GRAPH' here. hosts.yaml says for each host its address, and where needed user, ssh_port, command
(where graphnav is there) and folder (from which GRAPH is looked for there). ssh connects by your configuration, keys
and known_hosts, and asks nothing: it has to work without a password. The key of the link is new for each run and stored
nowhere. All end with the run, with Ctrl-C, and when a connection of ssh breaks.
"""


@command(
    *(one for one in command_called("run").parameters if isinstance(one, OneOf) or one.name not in _OF_ONE_COMPUTER),
    about=" ".join(_ABOUT.split()),
)
def main(args: CommandArguments) -> int:
    """Run the command."""
    from graphnav import UserError
    from graphnav.core.cli import run_graph
    from graphnav.core.notices import print_notice
    from graphnav.processes.hosts import declared_hosts
    from graphnav.processes.started_hosts import StartedHosts, words_for_hosts

    catalog, graph = args.load_graph(runs=True)
    declared = declared_hosts(graph, args.hosts)
    if not declared:
        what = f"no process of {graph.path.stem} lives on another host"
        raise UserError.of(what, "write deploy: {eyes: {stages: [flow], host: jetson}}, or use 'graphnav run'")
    told = words_for_hosts(args.graph, args.set, args.plugins)
    if args.portable is not None:
        told.append("--portable" if args.portable else "--no-portable")
    hosts = StartedHosts(declared, ["run", *told], print_notice)
    status = run_graph(args, catalog, graph, hosts)
    return Exit.FAILED if hosts.failure else status
