"""Runs with stages and plugins that misbehave in every method, in lockstep and live."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from attacks.misbehaving_plugins import HOOKS, intruding_plugin_text, plugin_text
from attacks.own_process import COMMAND, outcome_of
from attacks.verdict import faults
from attacks.zoo_stages import ENDINGS, INTRUSIONS, KINDS, SUMMARIES

ZOO = Path(__file__).resolve().parent / "zoo_stages.py"
_GRAPH = """\
run: {{until_s: 1}}
stages:
  c: {{use: zoo.clock{clock}}}
  b: {{use: {use}, in: {{twist: c.twist}}}}
"""
_BEFORE, _IN_RUN, _WITHIN = ("__init__", "check"), ("reset", "step", "summary", "close"), ("outputs",)
_REFUSED, _FAILED, _FINE = 2, 1, 0
_STALL_S = 1


class Misbehaviour(NamedTuple):
    """A graph, the plugin that it needs beside the zoo, and the exit status that a run of it must have.

    ``status``: None where the stage ends the process itself; ``info`` must then say that the run did not finish.
    """

    name: str
    graph: str
    status: int | None
    plugin: str = ""


def misbehaviours() -> Iterator[Misbehaviour]:
    """Yield every misbehaving stage with every method, and every misbehaving plugin."""
    for kind in KINDS:
        for method in (*_BEFORE, *_IN_RUN, *_WITHIN):
            status = _REFUSED if method in _BEFORE else _FAILED
            yield Misbehaviour(f"{kind} in {method}", _graph(_animal(kind, method)), status)
        yield Misbehaviour(f"{kind} in due_us", _graph("zoo.animal", f", with: {{kind: {kind}}}"), _FAILED)
        for hook in HOOKS:
            use = "strange.odd" if hook == "declaration" else "strange.still"
            yield Misbehaviour(f"{kind} in {hook}", _graph(use), _REFUSED, plugin_text(hook, kind))
    yield Misbehaviour("never due later", _graph("zoo.animal", ", with: {kind: never_later}"), _FAILED)
    for kind in SUMMARIES:
        yield Misbehaviour(f"summary: {kind}", _graph(f"zoo.liar, with: {{kind: {kind}}}"), _FAILED)
    for method in _IN_RUN:
        yield Misbehaviour(f"hangs in {method}", _graph(f"zoo.sleeper, with: {{method: {method}}}"), _FAILED)
    for method in ("step", "__init__"):
        yield Misbehaviour(f"chdir in {method}", _graph(f"zoo.mover, with: {{method: {method}}}"), _FINE)
    yield Misbehaviour("changes its input", _graph("zoo.meddler"), _FINE)
    for kind in INTRUSIONS:
        for method in (*_BEFORE, *_IN_RUN):
            yield Misbehaviour(f"{kind} in {method}", _graph(_animal(kind, method)), _FINE)
        yield Misbehaviour(f"{kind} in an import", _graph("strange.still"), _FINE, intruding_plugin_text(kind))
    for kind in ENDINGS:
        for method in _IN_RUN:
            yield Misbehaviour(f"the process ends: {kind} in {method}", _graph(_animal(kind, method)), None)


def misbehaving_stages(scratch: Path, count: int) -> Iterator[list[str]]:
    """Run ``count`` of the misbehaviours, spread over all, in lockstep, and as many live; yield what is wrong."""
    every = [(one, is_live) for is_live in (False, True) for one in misbehaviours()]
    count = min(count, len(every))
    url = f"udpm://239.255.93.{os.getpid() % 250 + 1}:{20_000 + os.getpid() % 10_000}?ttl=0"
    for number in range(count):
        one, is_live = every[number * len(every) // count]
        folder = scratch / f"misbehaviour-{number}"
        folder.mkdir()
        found = _wrong_with(one, folder, ["--live", "--url", url] if is_live else [])
        yield [f"{one.name}{', live' if is_live else ''}: {fault}" for fault in found]


def _animal(kind: str, method: str) -> str:
    return f"zoo.animal, with: {{kind: {kind}, method: {method}}}"


def _graph(use: str, clock: str = "") -> str:
    return _GRAPH.format(use=use, clock=clock)


def _wrong_with(one: Misbehaviour, folder: Path, words: list[str]) -> Iterator[str]:
    """Yield what is wrong with a run of a misbehaving stage, and with what it leaves."""
    (folder / "graph.yaml").write_text(one.graph)
    plugins = ["--plugin", str(ZOO)]
    if one.plugin:
        (folder / "strange.py").write_text(one.plugin)
        plugins += ["--plugin", "strange.py"]
    run = ["run", "graph.yaml", *plugins, "--stall-s", str(_STALL_S), "--no-tap", "--no-pictures", "-o", "out", *words]
    outcome = outcome_of([*COMMAND, *run], folder=folder)
    if one.status is None:
        info = outcome_of([*COMMAND, "info", "out"], folder=folder)
        yield from (f"info: {fault}" for fault in faults(info))
        if "the run did not finish" not in info.output:
            yield "info does not say that the run did not finish"
        return
    yield from faults(outcome)
    if outcome.status != one.status:
        yield f"exit status {outcome.status} instead of {one.status}"
    if one.status == _REFUSED:
        return
    summary = folder / "out" / "summary.json"
    if not summary.is_file():
        yield "no summary"
        return
    failure = json.loads(summary.read_text())["failure"]
    if bool(failure) != (one.status == _FAILED) or failure not in outcome.output:
        yield f"the summary's failure is {failure!r}"
    yield from (f"info: {fault}" for fault in faults(outcome_of([*COMMAND, "info", "out"], folder=folder)))
