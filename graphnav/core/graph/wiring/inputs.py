"""Inputs: channels that other programs write, and recorded ones that are played."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from graphnav.core.catalog import Catalog
from graphnav.core.errors import CatalogError, Problem
from graphnav.core.graph.node import Channel, InputChannel
from graphnav.core.graph.paths import resolve_paths
from graphnav.core.graph.wiring.wire_type import WireType, ros_type_read, type_read
from graphnav.core.messages import Message
from graphnav.core.spec import InputSpec, Spec


def input_messages(spec: Spec, catalog: Catalog) -> dict[str, type[Message]]:
    """Return what each input carries, by reference, as far as it is known: `inputs_of` says what is wrong."""
    return {ref: wire.message for ref, wire in _types(spec, catalog, []).items()}


def inputs_of(
    spec: Spec, catalog: Catalog, folder: Path, problems: list[Problem]
) -> tuple[dict[str, Channel], dict[str, InputChannel]]:
    """Return what stages can be wired to and where it comes from, each by reference; what is wrong is added.

    Logs resolve against the folder of the file that names them, by default ``folder``. An input whose type is known
    has a channel, also where something else is wrong with it.
    """
    channels: dict[str, Channel] = {}
    inputs: dict[str, InputChannel] = {}
    for ref, wire in _types(spec, catalog, problems).items():
        given = spec.inputs[ref]
        channels[ref] = Channel(ref, ref, wire.message)
        found = InputChannel(
            channels[ref],
            given.channel_name or ref,
            wire.lcm_class,
            wire.name,
            wire.adapter,
            given.max_age_s,
            None,
            given.place,
            ros_type=wire.ros_type,
        )
        if given.log is not None:
            base = spec.folders.get(given.log.value.place.file, folder)
            found = _with_log(found, given, base, problems)
        inputs[ref] = found
    for ref, given in spec.inputs.items():
        stem = ref.partition(".")[0]
        if stem in spec.stages:
            what = f"the input '{ref}' has the name of the stage '{stem}'"
            problems.append(Problem(given.place, what, "choose another name before the dot"))
    return channels, inputs


def _types(spec: Spec, catalog: Catalog, problems: list[Problem]) -> dict[str, WireType]:
    found = {}
    for ref, given in spec.inputs.items():
        if given.type is None:
            continue
        try:
            read = type_read if given.ros2 is None else ros_type_read
            found[ref] = read(str(given.type.value.data), catalog)
        except CatalogError as error:
            problems.append(error.problem(given.type.value.place, f"the input '{ref}': "))
    return found


def _with_log(found: InputChannel, given: InputSpec, folder: Path, problems: list[Problem]) -> InputChannel:
    assert given.log is not None
    value = given.log.value
    written = Path(str(value.data))
    resolved = resolve_paths(Path, written, folder)
    log = Path(resolved.value)
    if not _is(log.is_file):
        is_folder = _is(log.is_dir)
        what = f"'{written}' is a folder, not a log" if is_folder else f"there is no log '{written}'"
        hint = f"name the log in it: {written / 'run.lcmlog'}" if is_folder else "name a log"
        problems.append(Problem(value.place, f"the input '{found.channel.ref}': {what}", hint))
    return replace(found, log=log, log_written=written, log_anywhere=Path(resolved.anywhere))


def _is(question: Callable[[], bool]) -> bool:
    try:
        return question()
    except (OSError, ValueError):  # a name too long, or with a null character
        return False
