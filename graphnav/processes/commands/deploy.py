"""``graphnav deploy``: write what systemd or Docker Compose need to keep a live graph running."""

from __future__ import annotations

import getpass
import os
import re
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from graphnav.core.api import Shared
from graphnav.core.cli import CommandArguments, Exit
from graphnav.core.parameters import Parameter, command, seconds

if TYPE_CHECKING:
    from collections.abc import Iterator

    from graphnav import Graph

_EXAMPLES = """\
examples:
  graphnav deploy robot.yaml --to systemd -o units
  graphnav deploy robot.yaml --to compose -o box --processes --set control.max_speed_mps=0.3
"""
_VARIABLES = ("LCM_DEFAULT_URL",)
"""Of the environment in which the command runs, those that the run needs as well."""


@command(
    Shared.GRAPH,
    Parameter("to", "--to", choices=("systemd", "compose"), required=True, help="what keeps the graph running"),
    Parameter(
        "folder", "-o", type=Path, default=Path("units"), metavar="DIR", help="where to write (default: %(default)s)"
    ),
    Parameter("name", "--name", metavar="NAME", help="name of the service (default: the graph's)"),
    Parameter("user", "--user", metavar="USER", help="as whom it runs under systemd (default: you)"),
    Parameter(
        "restart",
        "--restart",
        choices=("on-failure", "always", "no"),
        default="on-failure",
        help="when a run that ended is started again (default: %(default)s: not if it reached its goal)",
    ),
    Parameter(
        "watchdog_s",
        "--watchdog-s",
        type=seconds,
        default=5.0,
        metavar="S",
        help="systemd ends a run whose engine does not turn for so long (default: %(default)s)",
    ),
    Shared.SET,
    Shared.PLUGINS,
    Shared.SEED,
    Shared.UNTIL_S,
    Shared.RECORD,
    Shared.PROCESSES,
    Shared.LIVE,
    Shared.LIVE_URL,
    about=_EXAMPLES,
)
def main(args: CommandArguments) -> int:
    """Run the command."""
    from graphnav import UserError
    from graphnav.core.bus import Bus
    from graphnav.core.errors import shown_name
    from graphnav.core.lcm_url import live_url
    from graphnav.processes.service_units import Service, compose_files, systemd_files

    _, graph = args.load_graph(runs=True)
    if not (args.live or graph.is_live):
        what = f"{graph.path.stem} runs in lockstep: it ends by itself, and nothing has to keep it running"
        raise UserError.of(what, "write --live to run it by the wall clock, or name a graph with inputs")
    name = re.sub(r"[^a-z0-9_-]+", "-", (args.name or graph.path.stem).lower()).strip("-_")
    if not name:
        raise UserError.of(f"{shown_name(args.name or graph.path.stem)} cannot name a service", "write --name robot")
    service = Service(
        name=name,
        about=" ".join(graph.about.split()),
        program=str(Path(sys.executable).with_name("graphnav")),
        arguments=["run", *_arguments(args, graph)],
        environment={one: os.environ[one] for one in _VARIABLES if os.environ.get(one)},
        reads=_folders(graph),
        works_in=Path.cwd(),
        user=args.user or getpass.getuser(),
        buffer_bytes=Bus.requested_buffer(live_url(graph, args.url)),
        restart=args.restart,
        watchdog_s=args.watchdog_s,
    )
    texts = systemd_files(service) if args.to == "systemd" else compose_files(service)
    _write(args.folder, texts)
    print("\n".join(_steps(service.unit, args.folder, args.to)))
    return Exit.OK


def _arguments(args: CommandArguments, graph: Graph) -> Iterator[str]:
    """Yield the arguments of the same ``graphnav run``; files are absolute where they are not of the working folder."""
    yield args.graph if _ships(graph.path) else str(graph.path.absolute())
    for one in args.set:
        yield from ("--set", one)
    for path in args.plugins:
        yield from ("--plugin", str(path.absolute()))
    for option in (Shared.SEED, Shared.UNTIL_S, Shared.RECORD, Shared.LIVE_URL):
        if (value := getattr(args, option.name)) is not None:
            yield from (option.flag, str(value))
    for option in (Shared.PROCESSES, Shared.LIVE):
        if getattr(args, option.name):
            yield option.flag
    yield "--no-pictures"


def _ships(path: Path) -> bool:
    from graphnav.core.graph import shipped_folder

    return path.is_relative_to(shipped_folder())


def _folders(graph: Graph) -> list[Path]:
    """Return the folders of the graph and its plugins that are not below the working folder."""
    paths = {path.absolute().parent for path in (graph.path, *graph.plugins) if not _ships(path)}
    return sorted(path for path in paths if not path.is_relative_to(Path.cwd()))


def _write(folder: Path, texts: dict[str, str]) -> None:
    """Write the files; only what this command wrote is replaced."""
    from graphnav import UserError
    from graphnav.core.errors import shown_name
    from graphnav.core.machine import write_atomically
    from graphnav.processes.service_units import WRITTEN

    where = shown_name(str(folder))
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for name in texts:
            path = folder / name
            if path.exists() and not path.read_bytes().startswith(WRITTEN.encode()):
                raise UserError.of(
                    f"{where}/{name} exists, and is not of this command", "choose another folder with -o"
                )
        for name, text in texts.items():
            write_atomically(folder / name, text)
    except OSError as error:
        raise UserError.of(f"cannot write into {where}: {error.strerror}", "choose another folder with -o") from error
    print(f"{where}: {', '.join(texts)}")


def _steps(unit: str, folder: Path, to: str) -> Iterator[str]:
    """Yield the commands that follow."""
    if to == "compose":
        yield f"  docker build -t IMAGE -f {folder}/Dockerfile FOLDER    IMAGE, FOLDER: see there"
        yield f"  docker compose -f {folder}/compose.yaml up -d"
        return
    yield f"  sudo cp {folder}/90-{unit}.conf /etc/sysctl.d/ && sudo sysctl --system"
    yield f"  sudo cp {folder}/{unit}.service /etc/systemd/system/ && sudo systemctl daemon-reload"
    yield f"  sudo systemctl enable --now {unit}"
    yield f"  journalctl -fu {unit}    what it prints; systemctl status {unit}: its faults"
