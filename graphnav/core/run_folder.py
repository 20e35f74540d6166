"""The files of a run folder that other folders of graphnav look for."""

from __future__ import annotations

from pathlib import Path


class RunFolder:
    """Names of the files in a run folder."""

    LOG = "run.lcmlog"
    GRAPH = "graph.yaml"
    """The graph as it ran, which runs again."""
    PLUGINS = "plugins"
    """The folder of the copies of its one-file plugins."""
    SUMMARY = "summary.json"
    PRINTED = "printed.txt"
    """All that a detached run printed."""
    OUTPUT = "processes"
    """The folder of what the stages of other processes printed."""


def is_graph_of_run(path: Path) -> bool:
    """Return whether ``path`` is the graph of a run folder, written by graphnav, not by a user."""
    return path.name == RunFolder.GRAPH and (path.parent / RunFolder.LOG).is_file()
