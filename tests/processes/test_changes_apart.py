"""Stages in processes of their own are changed while the run goes on, as those of one process are."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from graphnav.core.catalog import Catalog
from graphnav.core.cli import main
from graphnav.core.errors import GraphnavError
from graphnav.core.graph import Graph, load_graph, part_yaml
from graphnav.processes.hosted_changes import HostedChanges
from graphnav.processes.supervisor import Supervisor
from tests.processes.conftest import STAGES, Runs, request, restarted, steps_graph

PARTS = "deploy: {left: {stages: [clock, second, both, open]}, right: {stages: [fast, third]}}"
RIGHT = "deploy: {{right: {{stages: [third], {policy}}}}}"
CHANGES = {
    0.3: [request("slow.takes_ms=0", "second.takes_ms=0.5", "third.what=nothing")],  # here, and in both processes
    0.5: [request("third.at=3"), request("both=steps.pass"), request(restart="second")],
    0.9: [request("first=steps.both", "--set first.in.two=clock")],
    1.2: [request("both=steps.both", "--set both.in.two=open.sum"), request("second.takes_ms=-1")],
    1.7: [request(restart="third")],
}
"""Swaps, settings and restarts, of which one is refused, and one ends a stage that does not close."""
N_MADE = 9


def right(tmp_path: Path, policy: str, more: str = "") -> Graph:
    """Return the graph with one process, of the third stage."""
    return steps_graph(tmp_path, RIGHT.format(policy=policy), more=more)


class Noticed:
    """Waits after each kill until the supervisor has noticed it: a change that comes before is refused."""

    def __init__(self) -> None:
        self._n_kills = 0

    def __call__(self, supervisor: Supervisor) -> None:
        self._n_kills += 1
        while sum(map(len, supervisor.ends.values())) < self._n_kills:
            supervisor.wait()


@pytest.mark.parametrize("kills", [{}, {0.3: "left", 0.8: "right", 1.2: "right", 1.3: "left", 2.0: "right"}])
def test_the_log_is_that_of_one_process(
    runs: Runs, tmp_path: Path, kills: dict[float, str], capsys: pytest.CaptureFixture[str]
) -> None:
    """Also where processes are killed before, between and after the changes, and are fed again."""
    graph = restarted(steps_graph(tmp_path, PARTS, third="{what: close, at: 9}"))
    many = runs(graph, kills, killed=Noticed(), changes=CHANGES)
    one = runs(replace(graph, deploy={}), changes=CHANGES)
    assert many.agrees_with(one)
    assert len(one.summary.changes) == N_MADE
    assert many.answers == one.answers
    (notice,) = one.answers[0].notices
    assert notice.startswith("not closed: stage 'third' (steps.pass) failed at 0.30 s: close: it does not close\n")
    assert main(["replay", str(many.folder), "--plugin", str(STAGES)]) == 0
    assert capsys.readouterr().out.strip().splitlines()[-1].startswith("no differences: ")


def test_a_process_that_ends_while_it_makes_the_new_stage_comes_back_with_the_old_one(
    runs: Runs, tmp_path: Path
) -> None:
    graph = right(tmp_path, "restart: on_failure, restart_delay_s: 0.01")
    ran = runs(graph, changes={1.0: [request("third.what=exit")]})
    (answer,) = ran.answers
    assert [problem.what for problem in answer.problems] == [
        "stage 'third' (steps.pass) stays as it is: its process 'right' ended meanwhile"
    ]
    assert (ran.summary.processes or {})["right"]["ended"] == ["ended with exit status 3"]
    assert ran.agrees_with(runs(steps_graph(tmp_path)))


def test_a_process_that_is_given_up_is_not_changed(runs: Runs, tmp_path: Path) -> None:
    """Of a stage that never fires, so that the run goes on."""
    never = "  never: {use: steps.both, in: {one: even, two: fast}}\n"
    deploy = "deploy: {idle: {stages: [never]}}"
    ran = runs(
        steps_graph(tmp_path, deploy, more=never),
        {1.0: "idle"},
        killed=Noticed(),
        changes={1.0: [request("never=steps.pass")], 1.2: [request("first.at=7")]},
    )
    refused, made = ran.answers
    (problem,) = refused.problems
    assert str(problem) == (
        "stage 'never' (steps.both) stays as it is: its process 'idle' was killed by SIGKILL\n"
        "  write deploy: {idle: {stages: [never], restart: on_failure}} to have it started again and fed what it was "
        "given"
    )
    assert made.at_s == pytest.approx(1.2)
    assert ran.summary.outcome == "goal"


def test_a_family_that_is_new_to_a_process_has_the_code_that_the_run_has() -> None:
    graph = load_graph("corridor_ccw", Catalog())
    head = {"place": 0, "number": 1, "graph": part_yaml(graph, ["plane"]), "read": ["plane.plane"], "versions": {}}
    made = HostedChanges(graph.path, Catalog(), ()).take(head)
    assert (made.node.use, list(made.versions)) == ("plane.ica", ["code of plane"])
    assert HostedChanges(graph.path, Catalog(), ["plane"]).take(head).versions == {}
    other = {**head, "versions": {"code of plane": "0123"}}
    with pytest.raises(GraphnavError, match="its process does not have what the run has, but another code of plane"):
        HostedChanges(graph.path, Catalog(), ()).take(other)
