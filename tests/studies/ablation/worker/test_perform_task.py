"""A process that has other code than the study takes no part."""

from __future__ import annotations

from pathlib import Path

import pytest

from graphnav.core.runner import provenance
from graphnav.studies.ablation.worker.perform_task import Task, perform


@pytest.mark.parametrize("name", ["numpy", "code of plane"])
def test_a_process_that_is_not_the_same_makes_no_run(tmp_path: Path, name: str) -> None:
    versions = {**provenance(["plane"], []), name: "another"}
    task = Task("runs/a", "stages: {}", "a.yaml", (), 0, (), versions)
    result = perform(task, tmp_path)
    assert f"does not have what the study began with, but another {name}: another, now " in result.error
    assert not result.files
