"""Examples on the pages of maps and studies can be read, planned and driven."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
import yaml
from graphnav_world.maps.map_format import MAP
from graphnav_world.maps.world_map import load_map

from graphnav.core.catalog import Catalog
from graphnav.studies.ablation.plan import check_study
from graphnav.studies.ablation.study import study_of_command

from .conftest import DOCS, blocks, shell

MAPS, STUDIES = DOCS / "reference" / "maps.md", DOCS / "reference" / "studies.md"


def test_the_map_of_the_page_is_driven_by_the_command_of_the_page(tmp_path: Path) -> None:
    (tmp_path / "my_map.yaml").write_text(blocks(MAPS, "yaml")[0])
    command = blocks(MAPS, "sh")[0].strip()
    shell(f"{command} --until 1 --no-tap -o run", tmp_path, os.environ["LCM_DEFAULT_URL"])
    assert (tmp_path / "run" / "map.png").stat().st_size > 0


def test_every_world_of_the_map_of_the_page_leads_to_its_goal(tmp_path: Path) -> None:
    path = tmp_path / "my_map.yaml"
    path.write_text(blocks(MAPS, "yaml")[0])
    world = load_map(path, seed=1, robot_radius_m=0.2)
    assert 9 < world.shortest_m < 11
    assert [body.course is None for body in world.draw.bodies] == [True, True, True, False]


@pytest.mark.parametrize("text", blocks(MAPS, "yaml")[1:])
def test_every_part_that_the_page_shows_can_be_read(text: str) -> None:
    """A part is put into a map where it belongs: a shape becomes the goal, what moves an obstacle, an arc a wall."""
    part = yaml.safe_load(text)
    within = {
        "circle": "goal",
        "box": "goal",
        "polygon": "goal",
        "moves": "obstacles",
        "crosses": "obstacles",
        "arc": "walls",
    }
    where = next((within[name] for name in reversed(part) if name in within), "")
    complete = {
        "": part,
        "goal": {"goal": part},
        "obstacles": {"obstacles": [part]},
        "walls": {"walls": [{"along": [part]}]},
    }
    known = {"textures": {"brick": {"mean": 90}}, "start": {"at_m": [0, 0]}}
    _, problems = MAP.parse(yaml.safe_dump(known | complete[where]).encode(), "page")
    assert not problems


def test_the_study_of_the_page_can_be_planned(tmp_path: Path) -> None:
    path = tmp_path / "my_study.yaml"
    path.write_text(blocks(STUDIES, "yaml")[0])
    plan = check_study(study_of_command([str(path)]), Catalog(), "graphnav ablate my_study.yaml").plan
    assert len(plan.cases) == 6
    assert f"`{plan.command}`" in STUDIES.read_text()
