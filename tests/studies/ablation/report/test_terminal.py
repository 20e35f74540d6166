"""Tables of studies in the terminal."""

from __future__ import annotations

import dataclasses
import io
from typing import Any

from graphnav.core.machine.console import Console
from graphnav.studies.ablation.report import print_contrasts
from graphnav.studies.ablation.results import contrasts


def printed(plan: Any, records: Any) -> str:
    out = io.StringIO()
    print_contrasts(Console(file=out, width=200), contrasts(plan, records, [("affine", "ica")]), plan)
    return out.getvalue()


def test_a_contrast_marks_means_of_fewer_worlds_than_the_graph_has(make_plan: Any, make_record: Any) -> None:
    plan = make_plan(("ica", "affine"), range(50), {"drive.success": "higher"})
    plan = dataclasses.replace(plan, worlds={"corridor": 10})
    records = [
        make_record(name, seed, {"drive.success": float((seed + len(name)) % 2)})
        for seed in range(10)
        for name in ("ica", "affine")
    ]
    assert "affine (A), ica (B)" in printed(plan, records)
    assert "(n " not in printed(plan, records)
    assert "(n 9)" in printed(plan, records[1:])


def test_a_contrast_of_own_frames_says_so(make_plan: Any, make_record: Any) -> None:
    plan = make_plan(("ica", "affine"), range(3), {"sight.auroc": "higher"})
    declared = {name: dataclasses.replace(metric, of_frames=True) for name, metric in plan.declared.items()}
    cases = tuple(dataclasses.replace(case, drives_as=case.variant) for case in plan.cases)
    records = [make_record(name, seed, {"sight.auroc": 0.9}) for seed in range(3) for name in ("ica", "affine")]
    said = printed(dataclasses.replace(plan, declared=declared, cases=cases), records)
    assert said == "corridor: affine (A), ica (B): not compared: own frames\n"
    assert printed(plan, records[:1]) == "corridor: affine (A), ica (B): no world has runs of both\n"
