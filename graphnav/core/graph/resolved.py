"""Write a checked graph as YAML again, every parameter with its value and where it came from."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict
from typing import Any

from graphnav.core.graph.graph import Graph
from graphnav.core.graph.node import InputChannel, Node, OutputChannel, Part
from graphnav.core.ros2 import Ros2Network
from graphnav.core.spec import RunKeys, RunOptions, keys_of
from graphnav.core.spec.write import write_value


def resolved_yaml(graph: Graph, *, portable_paths: bool = True, plugins: Sequence[str] | None = None) -> str:
    """Return a graph as YAML with every parameter's value; it loads again.

    The text is the same on every machine: paths stand as they were written. Without ``portable_paths`` those that were
    found beside the graph or in the working folder are made absolute, and the plugins of ``--plugin`` are named too, so
    that the text loads from any folder. ``plugins``: the plugin files to name in place of those.
    """
    if plugins is None:
        plugins = graph.written_plugins if portable_paths else [str(path) for path in graph.plugins]
    return "\n".join(_lines(graph, plugins, portable_paths=portable_paths)) + "\n"


def _lines(graph: Graph, plugins: Sequence[str], *, portable_paths: bool) -> Iterator[str]:
    yield "# The graph as it ran: every parameter with its value."
    yield from (
        f"# {notice if notice.isprintable() else ascii(notice)}" for notice in (*graph.file_notices, *graph.notices)
    )
    if graph.about:
        yield f"about: {write_value(graph.about)}"
    if plugins:
        yield f"plugins: {write_value(plugins)}"
    yield "run:"
    for name in keys_of(RunKeys):
        yield f"  {name}: {write_value(_record(graph.run) if name == 'record' else getattr(graph.run, name))}"
    yield "stages:"
    for node in graph.nodes:
        yield from _node_lines(node, portable_paths=portable_paths)
    renamed = [channel for channel in graph.channels.values() if channel.name != channel.ref]
    if renamed:
        yield "channels:"
        yield from (f"  {channel.ref}: {write_value(channel.name)}" for channel in renamed)
    if graph.ros2 != Ros2Network():
        yield f"ros2: {write_value({key: value for key, value in asdict(graph.ros2).items() if value is not None})}"
    sections: dict[str, Mapping[str, Any]] = {
        "inputs": {ref: _input_words(i, portable_paths=portable_paths) for ref, i in graph.inputs.items()},
        "outputs": {ref: _output_words(output) for ref, output in graph.outputs.items()},
        "queues": {ref: {"keep": "all" if keep is None else keep} for ref, keep in graph.queues.items()},
        "deploy": {name: _part_words(part) for name, part in graph.deploy.items()},
    }
    for key, section in sections.items():
        if section:
            yield f"{key}:"
            yield from (f"  {write_value(name)}: {write_value(words)}" for name, words in section.items())


def _record(run: RunOptions) -> Any:
    """Return what the log keeps, as a mapping where its file is rotated."""
    words = {"keep": run.record, "rotate_mb": run.rotate_mb, "rotate_s": run.rotate_s}
    return words if run.rotate_mb is not None or run.rotate_s is not None else run.record


def _input_words(given: InputChannel, *, portable_paths: bool) -> dict[str, Any]:
    words: dict[str, Any] = {_source_key(given): given.name, "type": given.type_name}
    if given.log is not None:
        words = {"log": given.log_written if portable_paths else given.log_anywhere, **words}
    return words if given.max_age_s is None else {**words, "max_age_s": given.max_age_s}


def _output_words(given: OutputChannel) -> dict[str, Any]:
    words = {
        _source_key(given): given.name,
        "type": given.type_name,
        "motor": given.motor,
        "max_age_s": given.max_age_s,
    }
    return words if given.stop is None else {**words, "stop": given.stop}


def _source_key(given: InputChannel | OutputChannel) -> str:
    return "channel" if given.ros_type is None else "ros2"


def _part_words(part: Part) -> dict[str, Any]:
    return {key: value for key, value in asdict(part).items() if key != "name" and value is not None}


def _node_lines(node: Node, *, portable_paths: bool) -> Iterator[str]:
    yield f"  {node.name}:"
    yield f"    use: {node.use}" + _comment(node.use_note)
    if node.settings:
        yield "    with:"
    for name, setting in node.settings.items():
        value = setting.written if portable_paths else setting.anywhere
        yield f"      {name}: {write_value(value)}" + _comment("" if setting.origin == "graph" else setting.origin)
    wired = [(i.port.name, i.channel.ref, i.note) for i in node.inputs if i.channel is not None]
    if wired:
        yield "    in:"
    for port, ref, note in wired:
        yield f"      {port}: {ref}" + _comment(note)
    times = (("every_ms", node.every_ms), ("deadline_ms", node.deadline_ms))
    for key, ms in times:
        if ms is not None:
            yield f"    {key}: {write_value(ms)}" + _comment(node.time_notes.get(key, ""))


def _comment(note: str) -> str:
    return f"  # {note}" if note.isprintable() and note else ""
