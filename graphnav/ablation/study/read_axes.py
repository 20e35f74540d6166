"""Read the axes of a study from its file."""

from __future__ import annotations

from graphnav.ablation.study.axis_checks import axis_problems, plain_choice
from graphnav.ablation.study.study import Axis, Choice
from graphnav.ablation.study.value_reader import ValueReader
from graphnav.spec import Entry, Value

VARY = "write vary: {plane: [plane.ica, plane.affine]}"


def axes_of(vary: Entry, reader: ValueReader) -> tuple[Axis, ...]:
    """Return the axes under ``vary``: lists of what a target becomes, or mappings of labels to what each sets."""
    data = vary.value.data
    if not data:
        reader.problem(vary.place, "the study varies nothing", VARY)
        return ()
    if not isinstance(data, dict):
        reader.problem(vary.value.place, f"'vary' must be a mapping of axes, not {vary.value.kind}", VARY)
        return ()
    axes = []
    for name, entry in data.items():
        before = len(reader.problems)
        axis = Axis(name, _choices(name, entry, reader), entry.place)
        if len(reader.problems) == before:
            reader.problems += axis_problems(axis)
        axes.append(axis)
    return tuple(axes)


def _choices(axis: str, entry: Entry, reader: ValueReader) -> tuple[Choice, ...]:
    value = entry.value
    if isinstance(value.data, dict):
        return tuple(_named(axis, label, choice, reader) for label, choice in value.data.items())
    if isinstance(value.data, list):
        return tuple(_plain(axis, item, reader) for item in value.data)
    if value.data is not None:
        hint = f"write {axis}: [{reader.source.label(value)}, ...]"
        reader.problem(value.place, f"axis '{axis}' must be a list or a mapping, not {value.kind}", hint)
    return ()


def _plain(axis: str, item: Value, reader: ValueReader) -> Choice:
    if isinstance(item.data, dict):
        hint = f"name a choice that sets several things: {axis}: {{label: {{stage.parameter: value}}}}"
        reader.problem(item.place, f"axis '{axis}': a value in a list cannot be a mapping", hint)
    return plain_choice(axis, reader.source.text(item), item.place, reader.source.label(item))


def _named(axis: str, label: str, entry: Entry, reader: ValueReader) -> Choice:
    value = entry.value
    if value.data is None:
        return Choice(label, (), place=entry.place)
    if not isinstance(value.data, dict):
        what = f"choice '{label}' of axis '{axis}' must be a mapping of what it sets, not {value.kind}"
        reader.problem(value.place, what, f"write {label}: {{{axis}: {reader.source.label(value)}}}")
        return Choice(label, (), place=entry.place)
    sets = reader.sets(value, f"'{label}'")
    return Choice(label, tuple(sets), tuple(sets.values()), entry.place)
