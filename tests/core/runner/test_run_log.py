"""The log of a run: split into files that read as one, ended by a stop, and decoded where its types are unknown."""

from __future__ import annotations

import itertools
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from graphnav.core.catalog import Catalog
from graphnav.core.codec import codec_of, fingerprint, known_types, lcm_name, lcm_text_of, type_named
from graphnav.core.codec.given_types import add_given_types
from graphnav.core.errors import UserError
from graphnav.core.graph import Graph, Override, load_graph, resolved_yaml
from graphnav.core.messages import About, Twist
from graphnav.core.record import Recording
from graphnav.core.record.log_paths import parts_of
from graphnav.core.run_folder import RunFolder
from graphnav.core.runner.recording.run_recorded import run_recorded


@pytest.fixture
def drive(tmp_path: Path) -> Callable[..., Path]:
    """Return a function that drives for a second, with what the graph says of ``run``, and gives the log."""

    def run(name: str, words: str) -> Path:
        path = tmp_path / f"{name}.yaml"
        path.write_text(f"extends: approach\nrun: {{until_s: 1, record: {words}}}\n")
        graph = load_graph(path, Catalog())
        (tmp_path / name).mkdir()
        run_recorded(graph, graph.make_stages(), tmp_path / name)
        return tmp_path / name / RunFolder.LOG

    return run


def test_files_read_as_one_log_and_each_describes_itself(drive: Callable[..., Path]) -> None:
    entire, log = drive("entire", "all"), drive("split", "{keep: all, rotate_mb: 2, rotate_s: 0.7}")
    parts = parts_of(log)
    assert [path.name for path in parts] == [RunFolder.LOG, *(f"run.{n:04}.lcmlog" for n in range(1, len(parts)))]
    assert len(parts) > 2
    events = []
    for part in parts:
        assert part.stat().st_size <= 2e6
        with Recording(part.rename(part.with_name("part"))) as recording:
            assert recording.about is not None
            found = list(recording.events())
            assert found[0].channel == About.CHANNEL
            assert found[-1].utime - found[0].utime < 700_000
            events += found[1:]
        part.with_name("part").rename(part)
    with Recording(log) as recording, Recording(entire) as other:
        assert list(recording.events())[1:] == list(other.events())[1:] == events
        assert recording.n_bytes == sum(part.stat().st_size for part in parts)


def test_a_mapping_is_checked_by_line_and_loads_again(tmp_path: Path) -> None:
    path = tmp_path / "graph.yaml"
    path.write_text("extends: approach\nrun:\n  record: {keep: some, rotate_mb: -1, rotat_s: 3}\n")
    with pytest.raises(UserError) as caught:
        load_graph(path, Catalog())
    assert [(problem.place.line, problem.place.column) for problem in caught.value.problems if problem.place] == [
        (3, 18),
        (3, 35),
        (3, 39),
    ]
    with pytest.raises(UserError, match="rotate_mb") as caught:
        load_graph("approach", Catalog(), [Override.parse("run.record.rotate_mb=5")])
    hint = caught.value.problems[0].hint
    assert str(hint) == "its keys are set together: run.record={keep: small, rotate_mb: 500}"
    together = Override.parse("run.record={keep: small, rotate_mb: 500}")
    assert load_graph("approach", Catalog(), [together]).run.rotate_mb == 500
    path.write_text("extends: approach\nrun: {record: {keep: small, rotate_s: 60}}\n")
    graph = load_graph(path, Catalog())
    path.write_text(resolved_yaml(graph, portable_paths=False))
    again: Graph = load_graph(path, Catalog())
    assert again.run == graph.run
    assert (again.run.record, again.run.rotate_s, again.run.rotate_mb) == ("small", 60.0, None)
    assert load_graph("approach", Catalog(), [Override.parse("run.record=all")]).run.record == "all"


def test_the_last_command_is_a_stop_with_the_stamp_of_the_one_before(drive: Callable[..., Path]) -> None:
    with Recording(drive("run", "null")) as recording:
        *_, (before_us, before_seq, before), (utime, seq, last) = recording.messages("guard.twist")
        assert isinstance(before, Twist)
        assert isinstance(last, Twist)
        assert (last.v_mps, last.omega_radps) == (0.0, 0.0) != (before.v_mps, before.omega_radps)
        assert (utime, seq) == (before_us, before_seq + 1)
        assert list(recording.events())[-1].channel == "guard.twist"


def test_types_that_are_made_of_definitions_are_those_of_lcm_gen() -> None:
    Catalog().adapters()
    types = known_types()
    script = f"""
from graphnav.core.codec import add_type
from graphnav.core.codec.given_types import _made, _structs
from graphnav.core.codec import fingerprint
defined, made = dict(_structs({lcm_text_of(types)!r})), {{}}
for name in sorted(defined):
    print(name, fingerprint(_made(name, defined, made)).hex())
"""
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    found = dict(line.split() for line in done.stdout.splitlines())
    assert {name: found[name] for name in map(lcm_name, types)} == {
        lcm_name(one): fingerprint(one).hex() for one in types
    }


def _struct(name: str, *fields: str) -> str:
    return "\n".join([f"struct {name}", "{", *(f"    {field};" for field in fields), "}", ""])


@pytest.mark.parametrize("n_types", [5, 40, 900])
@pytest.mark.parametrize("n_fields", [1, 2])
def test_definitions_that_nest_deeply_cost_no_time(n_types: int, n_fields: int) -> None:
    own = f"nest_{n_types}_{n_fields}"
    inner = [_struct(f"{own}_{k}", *(f"{own}_{k + 1} {own}_f{j}" for j in range(n_fields))) for k in range(n_types)]
    add_given_types("\n".join([*inner, _struct(f"{own}_{n_types}", f"int8_t {own}")]))
    assert type_named(f"{own}_{n_types - 5}") is not None
    assert (type_named(f"{own}_0") is not None) == (n_types == 5)


def test_definitions_are_bounded_in_all() -> None:
    wide = _struct("wide", *(f"int8_t f{k}" for k in range(2000)))
    add_given_types("\n".join([wide, _struct("behind", "int8_t b"), _struct("int8_t", "int8_t c"), wide * 5]))
    assert type_named("wide") is type_named("int8_t") is None
    assert type_named("behind") is not None


def test_a_definition_may_contain_a_known_type_that_nests_others() -> None:
    add_given_types(_struct("with_status", "graphnav_lcm.status_t status"))
    made = type_named("with_status")
    assert made is not None
    assert codec_of(made).fields == ("status",)


@pytest.mark.parametrize("places", list(itertools.combinations(range(0, 60, 7), 2)))
def test_damaged_definitions_are_ignored(places: tuple[int, int]) -> None:
    text = "package own;\n\nstruct a_t\n{\n    int64_t utime;\n    own.a_t again;\n    int8_t x[n];\n}\n"
    add_given_types(text)
    add_given_types(text[places[0] :] + text[: places[1]])
    assert all(codec_of(one).name for one in known_types())
