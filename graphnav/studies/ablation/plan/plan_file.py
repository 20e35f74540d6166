"""``plan.json``: written, and read in this version or an earlier one.

No `Record` declares it: graphnav writes it and no user edits it, so it needs no reference page, no JSON Schema and no
advice by key. The annotations of the dataclasses that it holds are the declaration, and are checked.
"""

from __future__ import annotations

import dataclasses
import json
import math
import types
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Literal, Union, get_args, get_origin, get_type_hints

from graphnav import Metric, Place, shown_path
from graphnav.core.graph import Override, Target
from graphnav.core.machine import read_json, write_atomically
from graphnav.core.stage import FormerNames, unit_of
from graphnav.studies.ablation.plan.plan import Case, Plan
from graphnav.studies.ablation.study import Decomposition, MetricExpression


def save_plan(plan: Plan, path: Path) -> None:
    """Write a plan as JSON, atomically; the overrides of a case are a mapping of targets to values.

    Raises
    ------
    GraphnavError
        The disk refuses; an existing file is unchanged.
    """
    data = {field.name: getattr(plan, field.name) for field in dataclasses.fields(plan)}
    data["cases"] = [_case_json(case) for case in plan.cases]
    data["declared"] = {name: dataclasses.asdict(metric) for name, metric in plan.declared.items()}
    data["decomposition"] = plan.decomposition and dataclasses.asdict(plan.decomposition)
    write_atomically(path, json.dumps(data, indent=1) + "\n")


def load_plan(path: Path) -> Plan:
    """Read what `save_plan` wrote, in this version or an earlier one.

    Raises
    ------
    OSError, ValueError, KeyError, TypeError, AttributeError, UserError
        It cannot be read, or is not a plan.
    """
    data: dict[str, Any] = _as_written_now(read_json(path))
    data["declared"] = {name: _metric(declared) for name, declared in data["declared"].items()}
    data["cases"] = tuple(_case(case, Place(shown_path(path))) for case in data["cases"])
    if data.get("decomposition"):
        data["decomposition"] = Decomposition(**data["decomposition"])
    data["axes"] = {name: tuple(labels) for name, labels in data["axes"].items()}
    plan = Plan(**{key: _tuple(value) for key, value in data.items()})
    _check_types(plan)
    _check_consistent(plan)
    return plan


def _check_types(instance: Any) -> None:
    """Check every field of a dataclass, and those of the dataclasses in it.

    Raises
    ------
    TypeError
        A field holds something that its annotation excludes; names it.
    """
    kinds = get_type_hints(type(instance))
    for field in dataclasses.fields(instance):
        if not _fits(kinds[field.name], getattr(instance, field.name)):
            raise TypeError(f"{type(instance).__name__}.{field.name} has another type")


def _fits(kind: Any, value: Any) -> bool:
    origin, args = get_origin(kind), get_args(kind)
    if origin in (Union, types.UnionType):
        return any(_fits(one, value) for one in args)
    if origin is Literal:
        return isinstance(value, str | int) and value in args
    if origin is tuple:
        return isinstance(value, tuple) and _fit(args, value)
    if isinstance(origin, type) and issubclass(origin, Mapping):
        pairs = isinstance(value, Mapping) and value.items()
        return pairs is not False and all(_fits(args[0], key) and _fits(args[1], one) for key, one in pairs)
    if kind is float:
        return isinstance(value, int | float) and not isinstance(value, bool) and _is_finite(value)
    return kind is Any or (type(value) is kind and _are_fields_right(value))


def _are_fields_right(value: Any) -> bool:
    """Return True, once the fields of a dataclass are checked; other values have none."""
    if dataclasses.is_dataclass(value):
        _check_types(value)
    return True


def _fit(kinds: tuple[Any, ...], values: tuple[Any, ...]) -> bool:
    if kinds[-1] is Ellipsis:
        return all(_fits(kinds[0], value) for value in values)
    return len(kinds) == len(values) and all(map(_fits, kinds, values))


def _is_finite(value: float) -> bool:
    try:
        return math.isfinite(value)
    except OverflowError:  # an integer beyond what a float holds
        return False


def _check_consistent(plan: Plan) -> None:
    """Raise ValueError or UserError unless the cases, metrics and seeds of a plan that was read refer to each other."""
    known = {(case.graph, case.variant) for case in plan.cases}
    graphs = {case.graph for case in plan.cases}
    axes = {name: set(labels) for name, labels in plan.axes.items()}
    is_clear = (
        len(known) == len(plan.cases) > 0
        and graphs == set(plan.graphs)
        and graphs == {case.graph for case in plan.cases if case.is_base}
        and all(case.labels.keys() == axes.keys() for case in plan.cases)
        and all(label in axes[axis] for case in plan.cases for axis, label in case.labels.items())
        and all(not case.same_as or (case.graph, case.same_as) in known for case in plan.cases)
        and all(_is_below(case.folder) for case in plan.cases)
        and all(0 <= seed < 2**32 for seed in plan.seeds)
    )
    if not is_clear:
        raise ValueError("its cases do not agree with its graphs, axes or seeds")
    for column in plan.metrics:
        MetricExpression.parse(column)


def _is_below(folder: str) -> bool:
    """Return whether a relative path leads down from the folder that it begins at."""
    return folder != "" and "\0" not in folder and not Path(folder).is_absolute() and ".." not in Path(folder).parts


def _case_json(case: Case) -> dict[str, Any]:
    data = {field.name: getattr(case, field.name) for field in dataclasses.fields(case)}
    return data | {"overrides": {str(override.target): override.value for override in case.overrides}}


def _case(data: dict[str, Any], place: Place) -> Case:
    """Return a case of a plan; before 0.3.0 its overrides were strings for ``--set``."""
    fields = {key: _tuple(value) for key, value in data.items()}
    if "sets" in fields:
        overrides = [Override.parse(text, place) for text in fields.pop("sets")]
    else:
        overrides = [Override(Target.parse(key, place), value, place) for key, value in data["overrides"].items()]
    return Case(**fields | {"overrides": tuple(overrides)})


def _metric(declared: dict[str, Any]) -> Metric:
    return Metric(**{key: _tuple(value) for key, value in declared.items()})


def _tuple(value: Any) -> Any:
    return tuple(value) if isinstance(value, list) else value


def _as_written_now(data: dict[str, Any]) -> dict[str, Any]:
    """Return what ``plan.json`` holds, one of version 0.1.0 as this version would write it.

    Raises
    ------
    KeyError, TypeError, AttributeError
        It is not a plan.
    """
    if "metrics" in data:
        return data
    now = dict(data)
    columns = [MetricExpression.parse(text).renamed(FormerNames.metric_now) for text in now.pop("figures")]
    lower = [FormerNames.metric_now(name) for name in now.pop("less_is_better")]
    stages = dict.fromkeys(stage for case in data["cases"] for stage in case["uses"])
    operands = [name for column in columns for name in column.operands]
    zero = [f"{stage}.{name}" for stage in stages for name in FormerNames.ZERO_IF_FAILED]
    names = dict.fromkeys([*operands, *lower, *zero])
    now["metrics"] = [column.text for column in columns]
    now["declared"] = {name: vars(_former_metric(name, is_lower=name in lower)) for name in names}
    now["cases"] = [_former_case(case) for case in data["cases"]]
    return now


def _former_metric(name: str, *, is_lower: bool) -> Metric:
    metric = name.partition(".")[2]
    is_outcome = metric == FormerNames.OUTCOME
    return Metric(
        metric,
        help="",
        unit=unit_of(metric).symbol,
        better="lower" if is_lower else "higher",
        if_failed=0.0 if metric in FormerNames.ZERO_IF_FAILED else "measured",
        is_outcome=is_outcome,
    )


def _former_case(case: dict[str, Any]) -> dict[str, Any]:
    role = FormerNames.ROLES.get(case["role"], case["role"])
    return {**case, "role": role}
