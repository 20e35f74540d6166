"""Stages of this process that are to change: made and reset beside those that step, by threads of their own."""

from __future__ import annotations

import threading
from collections.abc import Callable, Collection
from contextlib import suppress
from pathlib import Path
from typing import Any, NamedTuple

from graphnav import Graph, GraphnavError, Problem, Stage, UserError
from graphnav.core.catalog import Catalog
from graphnav.core.errors import one_line
from graphnav.core.graph import Node, part_of
from graphnav.core.interrupts import third_party_code
from graphnav.core.runner import CODE, difference, giving_way, provenance, reset_stage
from graphnav.processes.frames import Frame, Kind


class Made(NamedTuple):
    """A stage that can take over: the ``graph`` that it is of has no other one."""

    graph: Graph
    stage: Stage
    patience_s: float
    """How long a live firing waits for `Since` inputs."""
    versions: dict[str, str]
    """Those of its code, if this process had none of its family."""

    @property
    def node(self) -> Node:
        """The stage of the graph."""
        return self.graph.nodes[0]


class HostedChanges:
    """Makes other stages in place of those of this process.

    ``path``: the graph's file. ``catalog`` has the plugins. ``families``: those of the stages of this process.
    """

    def __init__(self, path: Path, catalog: Catalog, families: Collection[str]) -> None:
        self._path, self._catalog, self._families = path, catalog, set(families)
        self._in_turn, self._lock = threading.Lock(), threading.Lock()
        self._numbers: dict[int, int] = {}
        """The last order for each place that is neither taken nor dropped."""
        self._made: dict[int, Made] = {}

    def prepare(self, head: dict[str, Any], tell: Callable[[Frame], None]) -> None:
        """Begin to make a stage; ``tell`` gets what became of it, in the thread that makes it."""
        with self._lock:
            self._numbers[head["place"]] = head["number"]
        threading.Thread(target=self._prepare, args=(head, tell), name="graphnav-change", daemon=True).start()

    def take(self, head: dict[str, Any]) -> Made:
        """Return the stage that was prepared for a place, or else make it now; raises UserError, GraphnavError."""
        with self._lock:
            self._numbers.pop(head["place"], None)
            made = self._made.pop(head["place"], None)
        return self._new(head) if made is None else made

    def drop(self, place: int) -> None:
        """Close the stage that was prepared for a place, if there is one, now or when it is made."""
        with self._lock:
            self._numbers.pop(place, None)
            made = self._made.pop(place, None)
        if made is not None:
            _close(made.stage)

    def _prepare(self, head: dict[str, Any], tell: Callable[[Frame], None]) -> None:
        told: dict[str, Any] = {"number": head["number"], "problems": []}
        try:
            with self._in_turn, giving_way():
                made = self._new(head)
        except UserError as error:
            told["problems"] = [[problem.what, str(problem.hint)] for problem in error.problems]
        except GraphnavError as error:
            told["problems"] = [[str(error), ""]]
        except Exception as error:  # noqa: BLE001 - whatever it is, the stages of this process go on
            told["problems"] = [[f"the stage cannot be made: {one_line(error)}", ""]]
        else:
            told |= {"patience_s": made.patience_s, "versions": made.versions}
            with self._lock:
                is_wanted = self._numbers.get(head["place"]) == head["number"]
                if is_wanted:
                    self._made[head["place"]] = made
            if not is_wanted:
                _close(made.stage)
        with suppress(OSError):  # the run is gone
            tell(Frame(Kind.PREPARED, told))

    def _new(self, head: dict[str, Any]) -> Made:
        """Return a new stage, reset.

        Raises
        ------
        UserError
            It cannot be made or reset.
        GraphnavError
            Its code is not that of the run.
        """
        graph = part_of(head["graph"], self._path, self._catalog, loads_plugins=False)
        (node,) = graph.nodes
        versions = self._versions(node.family, head["versions"])
        stage = graph.make_stages(head["read"])[node.name]
        try:
            reset_stage(stage, node, graph.run.seed)
            patience_s = _patience_s(stage, node)
        except UserError:
            _close(stage)
            raise
        return Made(graph, stage, patience_s, versions)

    def _versions(self, family: str, wanted: dict[str, str]) -> dict[str, str]:
        """Return the versions of the code of a family that this process did not have; raises GraphnavError."""
        if family in self._families:
            return {}
        versions = {name: version for name, version in provenance([family], ()).items() if name.startswith(CODE)}
        if other := difference(wanted, versions):
            raise GraphnavError(f"its process does not have what the run has, but {other}")
        self._families.add(family)
        return versions


def _patience_s(stage: Stage, node: Node) -> float:
    if not node.has_since:
        return 0.0
    try:
        with third_party_code():
            return float(stage.patience_s())
    except Exception as error:
        what = f"stage '{node.name}' ({node.use}) cannot be used: patience_s: {one_line(error)}"
        raise UserError(Problem(None, what)) from error


def _close(stage: Stage) -> None:
    with suppress(Exception):
        stage.close()
