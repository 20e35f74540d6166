"""Merge two mappings of graphs, every value with its own place; of stages also what a swap would change."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from graphnav.core.catalog import Catalog
from graphnav.core.errors import CatalogError, Place, Problem, did_you_mean
from graphnav.core.graph.overrides.carry_over import kept_params, kept_wires, lost_wires, params_notice, written_out
from graphnav.core.graph.wiring.stage_class import stage_class
from graphnav.core.spec import Entry, StageSpec, Value
from graphnav.core.stage import Stage

Words = dict[str, Entry]
"""A mapping of a file: keys and what is under them."""


def merge_entries(old: Entry, new: Entry, who: str, problems: list[Problem], *, null_removes: bool) -> Entry:
    """Return what is under one key when ``new`` overrides ``old``; ``who`` is what errors call it.

    Mappings are merged key by key, and nothing under a key changes nothing. With ``null_removes`` null removes a key
    and mappings in it are merged too; without it null is a value, and every value replaces the old one. What is not a
    mapping is replaced. A key that cannot be removed is added to ``problems``.
    """
    if new.value.data is None:
        return old
    if not isinstance(old.value.data, dict) or not isinstance(new.value.data, dict):
        return new
    words = dict(old.value.data)
    for key, entry in new.value.data.items():
        before = words.get(key)
        if not null_removes or (entry.value.data is not None and before is None):
            words[key] = entry
        elif entry.value.data is not None and before is not None:
            words[key] = merge_entries(before, entry, f"'{key}' of {who}", problems, null_removes=True)
        elif before is not None:
            del words[key]
        else:
            problems.append(_nothing_to_remove(f"{who} of the extended graph", key, entry, old.value.data))
    return Entry(new.place, Value(words, new.value.place))


def _nothing_to_remove(who: str, key: str, entry: Entry, known: dict[str, Entry]) -> Problem:
    """Return the problem of a null whose key the extended graph does not have."""
    hint = did_you_mean(key, known) or (f"it has {', '.join(known)}" if known else "it has none")
    return Problem(entry.place, f"null removes '{key}', but {who} has no such key", hint)


@dataclass(frozen=True)
class _Swap:
    """A stage whose ``use`` changed, and the parameters that it kept and lost."""

    name: str
    what: str
    new: type[Stage]
    kept: Words
    lost: tuple[str, ...]


class StageMerge:
    """Merges ``stages`` of one file after the other and keeps what has to be rewired afterwards."""

    def __init__(self, catalog: Catalog | None, problems: list[Problem]) -> None:
        self._catalog, self._problems = catalog, problems
        self._told: list[_Swap | str] = []
        self.swapped: dict[str, None] = {}
        """Stages whose ``use`` changed, in order."""
        self.removed: dict[str, Place] = {}
        """Stages and inputs that are null in a later file, with the place of the null."""
        self.given: set[tuple[str, str]] = set()
        """(stage, input port) of the wires that are given since the last swap."""
        self.read_before: set[str] = set()
        """Stages that some stage read before a swap."""

    def merge(self, old: Entry, new: Entry) -> Entry:
        """Return ``stages`` of two files, those of ``new`` over those of ``old``."""
        if new.value.data is None:
            return old
        if not isinstance(old.value.data, dict) or not isinstance(new.value.data, dict):
            return new
        over, stages = new.value.data, self._without_removed(old.value.data, new.value.data)
        uses = {name: _use(entry) for name, entry in over.items() if name in stages}
        changed = [name for name, use in uses.items() if use and use != _use(stages[name])]
        if changed:
            self.swapped |= dict.fromkeys(changed)
            self.given.clear()
            stages = self._written_out(stages)
            self.read_before |= {str(wire.value.data).partition(".")[0] for wire in _wires(stages)}
        for name, entry in over.items():
            if entry.value.data is None:
                continue
            self.given |= {(name, port) for port in _mapping(_mapping(entry).get("in"))}
            before = stages.get(name)
            if before is None or not isinstance(entry.value.data, dict):
                stages[name] = entry
                self.removed.pop(name, None)
            else:
                words = self._swapped(name, before, entry) if name in changed else dict(_mapping(before))
                stages[name] = Entry(entry.place, Value(self._over(name, words, entry), entry.value.place))
        return Entry(new.place, Value(stages, new.value.place))

    def note_removed(self, old: Entry, new: Entry) -> None:
        """Note which entries of ``inputs`` in ``old`` are null in ``new``, and which are put back."""
        for name, entry in _mapping(new).items():
            if entry.value.data is not None:
                self.removed.pop(name, None)
            elif name in _mapping(old):
                self.removed[name] = entry.place

    def notices(self, stages: Entry | None) -> Iterator[str]:
        """Yield what was swapped, lost and removed; ``stages``: what all files say together."""
        for told in self._told:
            if isinstance(told, str):
                yield told
            else:
                params = _mapping(_mapping(_mapping(stages).get(told.name)).get("with"))
                kept = [name for name, entry in told.kept.items() if params.get(name) is entry]
                given = [name for name in params if name not in kept]
                lost = [name for name in told.lost if name not in given]
                yield params_notice(told.what, told.new, kept, lost, given)

    def _without_removed(self, stages: Words, over: Words) -> Words:
        """Return the stages without those that are null in ``over``."""
        left = dict(stages)
        for name, entry in over.items():
            if entry.value.data is not None:
                continue
            if left.pop(name, None) is None:
                self._problems.append(_nothing_to_remove("'stages' of the extended graph", name, entry, stages))
            else:
                self.removed[name] = entry.place
                self._told.append(f"{name}: removed")
        return left

    def _over(self, name: str, words: Words, new: Entry) -> Words:
        """Return the words of a stage, those of ``new`` over ``words``."""
        for key, entry in _mapping(new).items():
            before = words.get(key)
            if key in ("with", "in") and before is not None:
                who = f"'{key}' of stage '{name}'"
                words[key] = merge_entries(before, entry, who, self._problems, null_removes=key == "in")
            elif entry.value.data is None and before is not None and key != "use":
                del words[key]
            else:
                words[key] = entry
        return words

    def _swapped(self, name: str, before: Entry, new: Entry) -> Words:
        """Return what a stage keeps when its ``use`` changes."""
        words, cls = dict(_mapping(before)), self._class(name, new)
        if cls is None:
            return words  # said by the check of the graph
        old, params, wires = self._class(name, before), _mapping(words.get("with")), _mapping(words.get("in"))
        kept = kept_params(params, old, cls)
        what = f"{name}: {_use(before)} swapped for {_use(new)}"
        self._told.append(_Swap(name, what, cls, kept, tuple(param for param in params if param not in kept)))
        self._told += lost_wires(name, wires, cls)
        for key, left in (("with", kept), ("in", kept_wires(wires, old, cls))):
            if key in words:
                words[key] = Entry(words[key].place, Value(dict(left), words[key].value.place))
        return words

    def _written_out(self, stages: Words) -> Words:
        """Return the stages with every reference to a stage's one output written as ``stage.port``."""
        classes = {name: cls for name, entry in stages.items() if (cls := self._class(name, entry))}
        found = {}
        for name, entry in stages.items():
            words = dict(_mapping(entry))
            if wires := _mapping(words.get("in")):
                wires = {port: written_out(wire, classes) for port, wire in wires.items()}
                words["in"] = Entry(words["in"].place, Value(wires, words["in"].value.place))
            found[name] = Entry(entry.place, Value(words, entry.value.place)) if wires else entry
        return found

    def _class(self, name: str, entry: Entry) -> type[Stage] | None:
        """Return the class of a stage, None where it is not known."""
        use, params = _use(entry), _mapping(_mapping(entry).get("with"))
        if not use or self._catalog is None:
            return None
        stage = StageSpec(name=name, place=entry.place, use=use, use_place=entry.place, params=params)
        try:
            return stage_class(stage, self._catalog, [])
        except CatalogError:
            return None


def _wires(stages: Words) -> Iterator[Entry]:
    for entry in stages.values():
        yield from _mapping(_mapping(entry).get("in")).values()


def _use(entry: Entry) -> str:
    """Return what a stage uses, empty where that is not said or is not a name."""
    use = _mapping(entry).get("use")
    return use.value.data if use and isinstance(use.value.data, str) else ""


def _mapping(entry: Entry | None) -> Words:
    """Return the mapping under a key, empty where there is none."""
    return entry.value.data if entry is not None and isinstance(entry.value.data, dict) else {}
