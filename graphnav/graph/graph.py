"""A checked graph: wiring, firing order, options."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from graphnav.errors import ParamError, Problem, UserError, one_line
from graphnav.graph.node import Channel, InputChannel, Node, OutputChannel
from graphnav.spec import RunOptions
from graphnav.stage import Metric, Stage, metrics_of


@dataclass(frozen=True)
class Graph:
    """A checked graph: stages with their parameters, wires and firing order."""

    path: Path
    about: str
    nodes: tuple[Node, ...]
    """All stages, in the file's order."""
    order: tuple[Node, ...]
    """Stages that are no sources, in firing order: writers before readers, ties in the file's order."""
    channels: Mapping[str, Channel]
    """By reference (``stage.port``), in the file's order."""
    run: RunOptions
    notices: tuple[str, ...] = ()
    """Changes made by swaps (rewired, pruned, set to defaults), and entries that are accepted but not used."""
    deploy: Mapping[str, Any] = field(default_factory=dict)
    """Which processes the stages would run in; lockstep does not use it."""
    inputs: Mapping[str, InputChannel] = field(default_factory=dict)
    """Channels that other programs write, by reference; their channels stand in ``channels`` too."""
    outputs: Mapping[str, OutputChannel] = field(default_factory=dict)
    """Channels that leave a live graph, by the reference of what is sent."""
    queues: Mapping[str, int | None] = field(default_factory=dict)
    """How many messages a plain input holds live, by ``stage.port``: each complete set of them fires, in order. None
    is as many as memory allows. Without an entry the newest complete set fires and older ones are overtaken."""
    plugins: tuple[Path, ...] = ()
    """One-file plugins that it needs, absolute: those that the graph names, and those of ``--plugin``."""
    written_plugins: tuple[str, ...] = ()
    """Those that the graph names, as it names them."""

    @property
    def is_live(self) -> bool:
        """Whether it can only run live, because other programs write some of its channels."""
        return bool(self.inputs)

    @property
    def sources(self) -> tuple[Node, ...]:
        """The stages that the clock fires, in the file's order."""
        return tuple(node for node in self.nodes if node.is_source)

    @property
    def metrics(self) -> Mapping[str, Mapping[str, Metric]]:
        """Declared metrics of each stage that reports any, by the names of stage and metric."""
        found = {node.name: metrics_of(node.stage_class) for node in self.nodes}
        return {name: declared for name, declared in found.items() if declared}

    def node(self, name: str) -> Node:
        """Return the stage called ``name``."""
        return next(node for node in self.nodes if node.name == name)

    def make_stages(self) -> dict[str, Stage]:
        """Return new stages by name, after each has looked at what its parameters name (`Stage.check`).

        Raises
        ------
        UserError
            All parameters that cannot be used and all stages that raise, each at its place.
        """
        stages: dict[str, Stage] = {}
        problems: list[Problem] = []
        for node in self.nodes:
            try:
                stages[node.name] = node.stage_class(**node.params)
                stages[node.name].check()
            except ParamError as error:
                problems.append(node.problem(error))
            except UserError as error:
                problems.extend(error.problems)
            except Exception as error:  # noqa: BLE001 - a plugin's constructor may raise anything
                problems.append(Problem(node.place, f"{node.use} cannot be made: {one_line(error)}", "fix the plugin"))
        if problems:
            raise UserError(problems)
        return stages
