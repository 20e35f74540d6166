"""Reports of runs that were made: maps with paths, and how failures ended."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import pytest

from graphnav.core.catalog import Catalog
from graphnav.core.cli import main
from graphnav.core.pictures import DRAWING_FAMILY
from graphnav.core.record import Recording
from graphnav.studies.ablation.plan.plan import Job, Plan
from graphnav.studies.ablation.report import EarlyMaps
from graphnav.studies.ablation.results.records import failure_folder, read_records

from .example_study import Page, plan_of, report

SETS = {"pca": (), "forward": ("steer=steer.forward",)}


@pytest.fixture(scope="module")
def study(tmp_path_factory: pytest.TempPathFactory) -> tuple[Plan, Path]:
    """Return a study of two short drives through one corridor, the second's end drawn."""
    folder = tmp_path_factory.mktemp("study")
    plan = plan_of({"pca": "method", "forward": "baseline"}, graphs=("corridor_ccw",), seeds=(3,))
    for case in plan.cases:
        sets = [word for text in (*SETS[case.variant], "run.until_s=1.5") for word in ("--set", text)]
        quiet = ["--no-tap", "--no-pictures", "--set", "run.record=small"]
        assert main(["run", "corridor_ccw", "--seed", "3", *sets, *quiet, "-o", str(folder / case.folder / "3")]) == 0
    catalog = Catalog()
    catalog.load(DRAWING_FAMILY)
    place = folder / failure_folder(plan.cases[1], 3)
    place.mkdir(parents=True)
    with Recording(folder / plan.cases[1].folder / "3" / "run.lcmlog") as recording:
        assert catalog.hook.graphnav_draw_end(recording=recording, file=place / "end.png")
    return plan, folder


def test_the_paths_of_all_variants_are_on_the_map(study: tuple[Plan, Path]) -> None:
    plan, folder = study
    text = report(plan, read_records(plan, folder), folder)
    Page(text)
    assert (folder / "paths" / "corridor_ccw" / "3.png").is_file()
    assert 'alt="paths through world 3 of corridor_ccw"' in text
    assert "seed 3: 2 timeout" in text


def test_a_first_world_is_drawn_when_its_last_run_is_made(study: tuple[Plan, Path]) -> None:
    plan, folder = study
    file = folder / "paths" / "corridor_ccw" / "3.png"
    report(plan, read_records(plan, folder), folder)
    at_the_end = file.read_bytes()
    file.unlink()
    early = EarlyMaps(plan, Catalog(), folder)
    early.add(Job(plan.cases[0], 3))
    assert not early.drawn
    early.add(Job(plan.cases[1], 3))
    assert early.drawn == {file}
    assert file.read_bytes() == at_the_end


def test_a_failure_shows_its_cause_and_its_panels(study: tuple[Plan, Path]) -> None:
    plan, folder = study
    text = report(plan, read_records(plan, folder), folder)
    gallery = text[text.index('<section id="failures">') : text.index('<section id="reproduce">')]
    assert "Time was up (1)" in gallery
    assert 'alt="forward on corridor_ccw, seed 3: timeout"' in gallery
    assert gallery.count("data:image/") == 1


def test_a_picture_that_is_none_is_named(study: tuple[Plan, Path], tmp_path: Path) -> None:
    plan, folder = study
    place = tmp_path / failure_folder(plan.cases[1], 3)
    place.mkdir(parents=True)
    (place / "end.png").write_bytes(b"this is no picture")
    text = report(plan, read_records(plan, folder), tmp_path)
    assert "end.png cannot be read" in text
    assert "the logs are gone" in text


def test_unreadable_logs_are_left_out(study: tuple[Plan, Path], tmp_path: Path) -> None:
    plan, folder = study
    records = [
        dataclasses.replace(record, folder=f"unreadable/{record.variant}") for record in read_records(plan, folder)
    ]
    for record in records:
        (tmp_path / record.folder).mkdir(parents=True)
        (tmp_path / record.folder / "run.lcmlog").write_bytes(b"no log of any kind, but some bytes")
    assert "the logs are gone" in report(plan, records, tmp_path)
