"""``extends: other.yaml``: the values of a graph's file override those of the files that it extends."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field

from graphnav.core.catalog import Catalog
from graphnav.core.errors import Place, Problem
from graphnav.core.graph.overrides.prune import forget, prune
from graphnav.core.graph.overrides.rewire import Rewiring
from graphnav.core.graph.read.graph_files import GraphFile
from graphnav.core.graph.read.merge import StageMerge, merge_entries
from graphnav.core.spec import SOURCE_KEYS, Entry, Spec, Value

_READ_BEFORE = ("extends", "plugins")
"""Keys that mean something before files are merged."""
_VALUES = ("run",)
"""Sections in which null is a value."""
_SECTIONS = ("channels", "inputs", "outputs", "queues", "deploy")
"""Sections in which null removes an entry of the extended graph."""
_WIRE_KEYS = {*SOURCE_KEYS, "type", "stop"}
"""Keys that an input or an output loses when its source is replaced by one of another kind."""


@dataclass(frozen=True)
class Merged:
    """Merged files of a graph, with the stages whose wires may have to be changed."""

    value: Value
    swapped: Collection[str] = ()
    """Stages that use another stage than in an extended file."""
    removed: dict[str, Place] = field(default_factory=dict)
    """Stages and inputs that are removed, with the place of the removal."""
    given: Collection[tuple[str, str]] = ()
    """(stage, input port) of the wires that are given with the swaps."""
    read_before: frozenset[str] = frozenset()
    """Stages that some stage read before the swaps."""


def merge_files(
    files: Sequence[GraphFile], catalog: Catalog | None, problems: list[Problem], notices: list[str]
) -> Merged:
    """Return the files of a graph merged into one, the first extended by the others in turn.

    Mappings are merged key by key; what is not a mapping is replaced. Null removes a stage, a wire or an entry of a
    section. A stage whose ``use`` changes is swapped as ``--set`` would swap it; without a catalog it keeps everything.
    """
    if len(files) == 1:
        return Merged(files[0].value)
    value = files[0].value
    stages = StageMerge(catalog, problems)
    for file in files[1:]:
        if not isinstance(value.data, dict | None):
            break  # told with the other errors of its shape
        value = _merged(value, file.value, stages, problems)
    words = value.data if isinstance(value.data, dict) else {}
    notices += stages.notices(words.get("stages"))
    return Merged(value, stages.swapped, stages.removed, stages.given, frozenset(stages.read_before))


def rewire_merged(spec: Spec, merged: Merged, catalog: Catalog, problems: list[Problem], notices: list[str]) -> None:
    """Rewire what swapped and removed stages of extended files leave open, and prune what is not read any more."""
    if not merged.swapped and not merged.removed:
        return
    rewiring = Rewiring(spec, catalog, merged.given, problems, notices)
    rewiring.remove(merged.removed)
    swapped = [name for name in merged.swapped if name in rewiring.classes()]
    rewiring.rewire(swapped)
    if swapped:
        prune(spec, set(merged.read_before), set(swapped), rewiring.classes(), notices)
    forget(spec, merged.removed, rewiring.classes(), notices)


def _merged(base: Value, over: Value, stages: StageMerge, problems: list[Problem]) -> Value:
    words = dict(base.data) if isinstance(base.data, dict) else {}
    for key, entry in over.data.items() if isinstance(over.data, dict) else ():
        old = words.get(key)
        if key in _READ_BEFORE:
            continue
        if key == "stages" and old is not None:
            words[key] = stages.merge(old, entry)
        elif key in (*_VALUES, *_SECTIONS) and old is not None:
            before = _without_sources(old, entry) if key in ("inputs", "outputs") else old
            words[key] = merge_entries(before, entry, f"'{key}'", problems, null_removes=key in _SECTIONS)
            if key == "inputs":
                stages.note_removed(old, entry)
        else:
            words[key] = entry
    return Value(words, over.place)


def _without_sources(old: Entry, new: Entry) -> Entry:
    """Return inputs or outputs without the channels, logs and types for which ``new`` has a topic, and vice versa."""
    if not isinstance(old.value.data, dict) or not isinstance(new.value.data, dict):
        return old
    words = dict(old.value.data)
    for ref, entry in words.items():
        over = new.value.data[ref].value.data if ref in new.value.data else None
        mine = entry.value.data
        if isinstance(over, dict) and isinstance(mine, dict) and _is_other_kind(mine, over):
            kept = {key: one for key, one in mine.items() if key not in _WIRE_KEYS or key in over}
            words[ref] = Entry(entry.place, Value(kept, entry.value.place), entry.is_override)
    return Entry(old.place, Value(words, old.value.place), old.is_override)


def _is_other_kind(old: Mapping[str, Entry], new: Mapping[str, Entry]) -> bool:
    """Whether one names a ROS 2 topic, and the other an LCM channel or a log."""
    given = {key for key in SOURCE_KEYS if key in new and new[key].value.data is not None}
    return bool(given) and ("ros2" in given) != ("ros2" in old)
