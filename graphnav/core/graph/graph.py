"""A checked graph: wiring, firing order, options."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

from graphnav.core.errors import ParamError, Problem, UserError, fix_the_plugin, one_line
from graphnav.core.graph.node import Channel, InputChannel, Node, OutputChannel, Part
from graphnav.core.graph.wiring.firing import firing_order
from graphnav.core.interrupts import CtrlC, third_party_code
from graphnav.core.machine.instruction_set import require_portable
from graphnav.core.messages import Twist
from graphnav.core.ros2 import Ros2Network
from graphnav.core.spec import RunOptions
from graphnav.core.stage import Metric, Stage, metrics_of, params_of, tell_readers


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
    """Changes made by ``--set`` (rewired, pruned, set to defaults), and entries that are accepted but not used."""
    file_notices: tuple[str, ...] = ()
    """Changes made by swaps in the files that it consists of (``extends``): the same whenever it is loaded."""
    inputs: Mapping[str, InputChannel] = field(default_factory=dict)
    """Channels that other programs write, by reference; their channels stand in ``channels`` too."""
    outputs: Mapping[str, OutputChannel] = field(default_factory=dict)
    """Channels that leave a live graph, by the reference of what is sent."""
    queues: Mapping[str, int | None] = field(default_factory=dict)
    """How many messages a plain input holds live, by ``stage.port``: each complete set of them fires, in order. None
    is as many as memory allows. Without an entry the newest complete set fires and older ones are overtaken."""
    ros2: Ros2Network = field(default_factory=Ros2Network)
    """Where the ROS 2 programs are whose topics are inputs and outputs."""
    deploy: Mapping[str, Part] = field(default_factory=dict)
    """The processes of a run, by name; stages that none of them names live in that of the command."""
    plugins: tuple[Path, ...] = ()
    """One-file plugins that it needs, absolute: those that the graph names, and those of ``--plugin``."""
    written_plugins: tuple[str, ...] = ()
    """Those that the graph names, as it names them."""
    left_out: tuple[Problem, ...] = ()
    """Plugins that are not trusted and did not run: the graph can be drawn, but not run; their stages are `LeftOut`."""

    @property
    def is_live(self) -> bool:
        """Whether it can only run live, because some of its messages come from outside."""
        return bool(self.arriving)

    @property
    def arriving(self) -> tuple[str, ...]:
        """Inputs, by reference, and stages that take what a device delivers, by name: they make it live."""
        return (*self.inputs, *(node.name for node in self.nodes if node.is_live_source))

    @property
    def sources(self) -> tuple[Node, ...]:
        """The stages that the clock fires, in the file's order."""
        return tuple(node for node in self.nodes if node.is_source)

    def with_processes(self) -> Graph:
        """Return the graph with a process of its own for each stage that ``deploy`` does not name and may have one."""
        parts = dict(self.deploy)
        homeless = {node.name for node in self.nodes if not node.is_live_source}.difference(
            *(part.stages for part in parts.values())
        )
        for node in self.nodes:
            if node.name in homeless:
                name = node.name if node.name not in parts else f"{node.name}_alone"
                parts[name] = Part(name, (node.name,))
        return replace(self, deploy=parts)

    @property
    def commands(self) -> tuple[Channel, ...]:
        """The channels of commands that sources sample: what moves the robot of a world."""
        found = (i.channel for node in self.sources for i in node.inputs if i.channel is not None)
        return tuple({channel.name: channel for channel in found if channel.message is Twist}.values())

    @property
    def metrics(self) -> Mapping[str, Mapping[str, Metric]]:
        """Declared metrics of each stage that reports any, by the names of stage and metric."""
        found = {node.name: metrics_of(node.stage_class) for node in self.nodes}
        return {name: declared for name, declared in found.items() if declared}

    def without_left_out(self) -> Graph:
        """Return the graph of the stages that are known."""
        known = tuple(node for node in self.nodes if not node.is_left_out)
        return replace(self, nodes=known, order=tuple(node for node in self.order if node in known), left_out=())

    def node(self, name: str) -> Node:
        """Return the stage called ``name``."""
        return next(node for node in self.nodes if node.name == name)

    def with_nodes(self, changed: Iterable[Node]) -> Graph:
        """Return the graph with other stages in place of those of the same names, in the firing order of its wires."""
        by_name = {node.name: node for node in self.nodes} | {node.name: node for node in changed}
        order, _ = firing_order({name: node.writers for name, node in by_name.items()})
        written = {channel.ref: channel for node in by_name.values() for channel in node.outputs.values()}
        return replace(
            self,
            nodes=tuple(by_name.values()),
            order=tuple(by_name[name] for name in order if not by_name[name].is_source),
            channels={ref: self.channels[ref] for ref in self.inputs} | written,
        )

    @property
    def read(self) -> frozenset[str]:
        """The references of the channels that a stage or an entry of ``outputs`` reads."""
        return frozenset(i.channel.ref for node in self.nodes for i in node.inputs if i.channel) | set(self.outputs)

    def make_stages(self, also_read: Collection[str] = ()) -> dict[str, Stage]:
        """Return new stages by name, after each has looked at what its parameters name (`Stage.check`).

        ``also_read``: channels that are read elsewhere, by reference, so that stages publish them (`Stage.is_read`).

        Raises
        ------
        UserError
            All parameters that cannot be used and all stages that raise, each at its place; or the graph is to run
            portably, which this process cannot; or plugins are left out.
        """
        if self.left_out:
            raise UserError(self.left_out)
        if self.run.portable:
            require_portable()
        stages, problems = self._made(self.nodes, self.read.union(also_read))
        if problems:
            raise UserError(problems)
        return stages

    def make_stage(self, name: str) -> Stage:
        """Return one new stage, as `make_stages` does.

        Raises
        ------
        UserError
            All of its parameters that cannot be used, or what it raises.
        """
        stages, problems = self._made([self.node(name)], self.read)
        if problems:
            raise UserError(problems)
        return stages[name]

    def stage_problems(self) -> list[Problem]:
        """Return what `make_stages` would refuse in the stages all of whose parameters could be read.

        For a graph in which something else is wrong, so that all of its errors are reported together.
        """
        return self._made(
            [n for n in self.without_left_out().nodes if n.settings.keys() == params_of(n.stage_class).keys()],
            self.read,
        )[1]

    @staticmethod
    def _made(nodes: Iterable[Node], read: Collection[str]) -> tuple[dict[str, Stage], list[Problem]]:
        """Return new stages by name, and what is wrong with the others; ``read``: the channels that are read."""
        stages: dict[str, Stage] = {}
        problems: list[Problem] = []
        for node in nodes:
            try:
                with third_party_code():
                    stages[node.name] = stage = node.stage_class(**node.params)
                    tell_readers(stage, (port for port, channel in node.outputs.items() if channel.ref in read))
                    stage.check()
            except CtrlC:
                raise
            except BaseException as error:  # noqa: BLE001 - a plugin's constructor may raise anything
                problems.extend(_problems(node, error))
        return stages, problems


def _problems(node: Node, error: BaseException) -> Iterator[Problem]:
    """Yield what a stage's constructor or check raised as problems at the stage and its parameters."""
    if isinstance(error, BaseExceptionGroup):
        for one in error.exceptions:
            yield from _problems(node, one)
    elif isinstance(error, ParamError):
        yield node.problem(error)
    elif isinstance(error, UserError):
        yield from error.problems
    else:
        yield _plugin_problem(node, error)


def _plugin_problem(node: Node, error: BaseException) -> Problem:
    hint = fix_the_plugin(error, (cls.__module__ for cls in node.stage_class.__mro__))
    return Problem(node.place, f"{node.use} cannot be made: {one_line(error)}", hint, raised=error)
