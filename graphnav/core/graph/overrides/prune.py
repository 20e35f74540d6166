"""Remove the stages that no other stage reads any more after a swap."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Any

from graphnav.core.spec import Spec
from graphnav.core.stage import Source, Stage, ports_of


def prune(
    spec: Spec, read_before: set[str], swapped: set[str], classes: Mapping[str, type[Stage]], notices: list[str]
) -> None:
    """Remove the stages that had readers and have none now, and what the graph says of them.

    Sinks and what leaves stay, without inputs the last source too. ``read_before``: the stages that were read
    before the swap.
    """
    while unread := _unread(spec, read_before, classes):
        del spec.stages[unread]
        notices.append(f"{unread}: pruned, no stage reads it any more")
    forget(spec, {name for name in classes if name in swapped or name not in spec.stages}, classes, notices)


def forget(spec: Spec, gone: Collection[str], classes: Mapping[str, type[Stage]], notices: list[str]) -> None:
    """Remove what the graph says of channels and inputs that stages which are ``gone`` or swapped do not have now."""
    channels = {f"{s}.{p.name}" for s, cls in classes.items() if s in spec.stages for p in ports_of(cls).outputs}
    inputs = {f"{s}.{p.name}" for s, cls in classes.items() if s in spec.stages for p in ports_of(cls).inputs}
    dead = [ref for ref in spec.channels if ref.partition(".")[0] in gone and ref not in channels]
    notices += [
        f"channels: '{ref}' is gone, and its name {spec.channels.pop(ref).value.plain()} with it" for ref in dead
    ]
    _forget(spec.outputs, channels, gone, notices, "outputs: '{}' is gone: nothing leaves in its place")
    _forget(spec.queues, inputs, gone, notices, "queues: '{}' is gone, and what it holds")
    _forget_homes(spec, gone)


def _forget_homes(spec: Spec, gone: Collection[str]) -> None:
    """Take stages that are gone out of their processes, and remove the processes that are empty then."""
    for name, part in list(spec.deploy.items()):
        part.stages = [(stage, place) for stage, place in part.stages if stage not in gone or stage in spec.stages]
        if not part.stages:
            del spec.deploy[name]


def _forget(section: dict[str, Any], left: set[str], gone: Collection[str], notices: list[str], notice: str) -> None:
    """Remove the entries of ports that went with their stage."""
    for ref in [ref for ref in section if ref.partition(".")[0] in gone and ref not in left]:
        del section[ref]
        notices.append(notice.format(ref))


def _unread(spec: Spec, read_before: set[str], classes: Mapping[str, type[Stage]]) -> str | None:
    """Return a stage that has outputs, but lost its last reader."""
    read = {str(e.value.data).partition(".")[0] for stage in spec.stages.values() for e in stage.wires.values()}
    read |= {ref.partition(".")[0] for ref in spec.outputs}
    sources = [name for name in spec.stages if name in classes and issubclass(classes[name], Source)]
    for name in spec.stages:
        lost = name in read_before and name not in read and name in classes
        if lost and ports_of(classes[name]).outputs and (sources != [name] or spec.inputs):
            return name
    return None
