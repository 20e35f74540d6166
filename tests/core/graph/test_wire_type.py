"""LCM types of other packages are found where they are installed, or through a one-file plugin's adapter."""

import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from graphnav.core.catalog import Catalog
from graphnav.core.errors import UserError
from graphnav.core.graph import Graph, load_graph

FIXTURE = Path(__file__).parent.parent.parent / "fixtures" / "graphnav_fixture_pkg"
TYPES = "graphnav_fixture_lcm"

ADAPTER = '''\
"""Motion from notes and commands as notes."""

from graphnav import Adapter, Motion, Stage, Twist, hookimpl

import graphnav_fixture_lcm


class NoteOdometry(Adapter):
    """Reads how far a note says that the robot went."""

    type_name = "graphnav_fixture_lcm.note_t"
    lcm_class = graphnav_fixture_lcm.note_t
    message = Motion

    def from_lcm(self, fields):
        return Motion(forward_m=fields["mean"], left_m=0.0, turn_rad=0.0, interval_us=1)


class NoteCommand(Adapter):
    """Writes a command as a note."""

    type_name = "graphnav_fixture_lcm.note_t"
    lcm_class = graphnav_fixture_lcm.note_t
    message = Twist

    def to_lcm(self, message, utime):
        return {"utime": utime, "seq": 0, "text": "go", "mean": message.v_mps}


class Follow(Stage):
    """Drives as fast as it went."""

    is_guard = True

    def step(self, motion: Motion) -> Twist:
        return Twist(v_mps=motion.forward_m, omega_radps=0.0)


@hookimpl
def graphnav_stages():
    return [Follow]


@hookimpl
def graphnav_adapters():
    return [NoteOdometry, NoteCommand()]
'''

GRAPH = """\
inputs: {{base.motion: {{channel: NOTES, type: {type}}}}}
stages:
  follow: {{use: notes.follow, every_ms: 50, in: {{motion: base}}}}
outputs: {{follow.twist: {{channel: COMMANDS, type: {type}, motor: true}}}}
"""


@pytest.fixture(autouse=True)
def _installed(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Install the fixture's LCM types for one test."""
    monkeypatch.syspath_prepend(FIXTURE)
    yield
    for name in [name for name in sys.modules if name.partition(".")[0] in (TYPES, "broken_lcm")]:
        del sys.modules[name]


def loaded(folder: Path, plugin: str, type_name: str = f"{TYPES}.note_t") -> Graph:
    (folder / "notes.py").write_text(plugin)
    (folder / "graph.yaml").write_text(GRAPH.format(type=type_name))
    catalog = Catalog()
    catalog.add_file(folder / "notes.py")
    return load_graph(folder / "graph.yaml", catalog)


def refused(folder: Path, plugin: str, type_name: str = f"{TYPES}.note_t") -> list[str]:
    with pytest.raises(UserError) as caught:
        loaded(folder, plugin, type_name)
    return [str(problem).replace(f"{folder}/", "") for problem in caught.value.problems]


def test_a_one_file_plugin_brings_adapters_for_the_types_of_others(tmp_path: Path) -> None:
    graph = loaded(tmp_path, ADAPTER)
    given, sent = graph.inputs["base.motion"], graph.outputs["follow.twist"]
    assert given.lcm_class is sent.lcm_class is sys.modules[TYPES].note_t
    assert type(given.adapter).__name__ == "NoteOdometry"
    assert type(sent.adapter).__name__ == "NoteCommand"
    assert given.channel.message.__name__ == "Motion"


def test_a_type_that_is_installed_but_means_nothing_here_needs_a_message_or_an_adapter(tmp_path: Path) -> None:
    (said, *_) = refused(tmp_path, ADAPTER.replace("return [NoteOdometry, NoteCommand()]", "return []"))
    assert "'graphnav_fixture_lcm.note_t' is installed, but no message wraps it and no adapter reads it" in said
    assert "write class Note(Message, lcm=graphnav_fixture_lcm.note_t), or an Adapter" in said


@pytest.mark.parametrize("raised", ["OSError('no\\nlicence')", "SystemExit(3)", "ImportError()"])
def test_a_package_that_raises_on_import_is_told_in_one_line(
    tmp_path: Path, raised: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    package = tmp_path / "broken_lcm"
    package.mkdir()
    (package / "__init__.py").write_text(f"raise {raised}")
    (package / "note_t.py").touch()
    monkeypatch.syspath_prepend(tmp_path)
    (said, *_) = refused(tmp_path, ADAPTER, "broken_lcm.note_t")
    what, hint = said.splitlines()
    assert "the package of 'broken_lcm.note_t' cannot be imported: " in what
    assert hint == "  fix the package"


def test_a_class_that_lcm_gen_did_not_finish_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    package = tmp_path / "broken_lcm"
    package.mkdir()
    (package / "__init__.py").write_text("from .note_t import note_t")
    (package / "note_t.py").write_text("class note_t:\n    __typenames__ = ['double']\n")
    monkeypatch.syspath_prepend(tmp_path)
    (said, *_) = refused(tmp_path, ADAPTER, "broken_lcm.note_t")
    assert "'broken_lcm.note_t' is not what lcm-gen makes: AttributeError" in said
