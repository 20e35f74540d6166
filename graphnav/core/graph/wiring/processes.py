"""``deploy``: which stages live in which process."""

from __future__ import annotations

from collections.abc import Collection, Mapping

from graphnav.core.errors import Hint, Problem, did_you_mean
from graphnav.core.graph.node import Part
from graphnav.core.spec import Spec
from graphnav.core.stage import LiveSource, Stage


def parts_of(spec: Spec, classes: Mapping[str, type[Stage]], problems: list[Problem]) -> dict[str, Part]:
    """Return the processes of a graph by name; what is wrong is added to ``problems``."""
    live = {stage for stage, cls in classes.items() if issubclass(cls, LiveSource)}
    homes: dict[str, str] = {}
    parts = {}
    for name, part in spec.deploy.items():
        keys = part.keys
        for stage, place in part.stages:
            if stage in spec.stages and stage not in (*homes, *live):
                homes[stage] = name
            else:
                problems.append(Problem(place, *_why_not(spec, name, stage, homes, live)))
        stages = tuple(stage for stage, _ in part.stages)
        parts[name] = Part(
            name, stages, keys.restart, keys.max_restarts, keys.restart_window_s, keys.restart_delay_s, keys.host
        )
    return parts


def _why_not(spec: Spec, part: str, stage: str, homes: dict[str, str], live: Collection[str]) -> tuple[str, Hint]:
    """Return why a process cannot have a stage, and a hint; ``live``: the stages that take what a device delivers."""
    if stage in live:
        who = f"the process '{part}' names stage '{stage}' ({spec.stages[stage].use})"
        return f"{who}, which takes what a device delivers: it lives in the process of the run", "remove it"
    if stage in homes:
        also = "twice" if homes[stage] == part else f"that '{homes[stage]}' has already"
        return f"the process '{part}' names stage '{stage}' {also}", "name each stage once: it lives in one process"
    if any(stage in (ref, ref.partition(".")[0]) for ref in spec.inputs):
        what = f"the process '{part}' names the input '{stage}', which comes from outside of the graph"
        return what, "remove it: only stages live in processes"
    near = did_you_mean(stage.partition(".")[0], spec.stages)
    return f"there is no stage '{stage}'", near or f"stages are {', '.join(spec.stages)}"
