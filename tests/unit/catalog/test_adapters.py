"""Adapters are found in files, families and the reserved family ``adapters``; what is not an adapter is told."""

from importlib.metadata import EntryPoint
from pathlib import Path

import pytest

import graphnav.catalog
from graphnav.catalog import Catalog
from graphnav.errors import CatalogError

ADAPTER = """\
import graphnav_lcm
from graphnav import Adapter, Stop, Twist, hookimpl

class Read(Adapter):
    type_name = "{name}"
    lcm_class = graphnav_lcm.stop_t
    message = Twist

    def from_lcm(self, fields):
        return Twist(v_mps=0.0, omega_radps=0.0)

class Write(Adapter):
    type_name = "{name}"
    lcm_class = graphnav_lcm.stop_t
    message = Twist

    def to_lcm(self, message, utime):
        return {{"utime": utime, "seq": 0, "engaged": True, "reason": ""}}

@hookimpl
def graphnav_adapters():
    return {given}
"""


def plugin(folder: Path, given: str, name: str = "test.stop_t", file: str = "mine.py") -> Path:
    path = folder / file
    path.write_text(ADAPTER.format(name=name, given=given))
    return path


def refused(*paths: Path) -> str:
    """Return the error for the adapters of files, without their folder."""
    catalog = Catalog()
    for path in paths:
        catalog.add_file(path)
    with pytest.raises(CatalogError) as caught:
        catalog.adapters()
    return str(caught.value).replace(f"{paths[0].parent}/", "")


def test_a_file_brings_one_adapter_for_each_direction(tmp_path: Path) -> None:
    catalog = Catalog()
    catalog.add_file(plugin(tmp_path, "[Read, Write()]"))
    found = catalog.adapters()
    assert found.readers["test.stop_t"] is not found.writers["test.stop_t"]
    assert catalog.adapters() is found


def test_a_file_that_is_added_later_is_seen(tmp_path: Path) -> None:
    catalog = Catalog()
    assert "test.stop_t" not in catalog.adapters().readers
    catalog.add_file(plugin(tmp_path, "[Read]"))
    assert "test.stop_t" in catalog.adapters().readers


def test_a_plugin_without_stages_is_not_a_family(tmp_path: Path) -> None:
    catalog = Catalog()
    assert catalog.add_file(plugin(tmp_path, "[Read]")) == "mine"
    assert catalog.add_file(plugin(tmp_path, "[]", file="adapters.py")) == "adapters"
    assert not {"mine", "adapters"} & set(catalog.families())


def test_packages_of_the_reserved_family_are_loaded_when_adapters_are_asked_for(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    plugin(tmp_path, "[Read]", file="shipped_adapters.py")
    monkeypatch.syspath_prepend(tmp_path)
    points = [EntryPoint("adapters", "shipped_adapters", "graphnav"), EntryPoint("flow", "graphnav_flow", "graphnav")]
    monkeypatch.setattr(graphnav.catalog, "entry_points", lambda **_: points)
    catalog = Catalog()
    assert catalog.families() == ("flow",)
    assert list(catalog.adapters().readers) == ["test.stop_t"]
    assert catalog.families() == ("flow",)
    with pytest.raises(CatalogError, match="there is no family 'adapters'"):
        catalog.stage("adapters.stage")


def test_a_package_of_adapters_that_cannot_be_imported_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(
        graphnav.catalog, "entry_points", lambda **_: [EntryPoint("adapters", "no_such_package", "graphnav")]
    )
    with pytest.raises(CatalogError, match="family 'adapters' cannot be imported from module no_such_package"):
        Catalog().adapters()


def test_stages_cannot_be_in_the_reserved_family(tmp_path: Path) -> None:
    path = tmp_path / "adapters.py"
    path.write_text(
        "from graphnav import Image, Stage, hookimpl\n\n\nclass Same(Stage):\n"
        "    def step(self, image: Image) -> Image:\n        return image\n\n\n"
        "@hookimpl\ndef graphnav_stages():\n    return [Same]\n"
    )
    with pytest.raises(CatalogError, match=r"the family 'adapters' is reserved\n  give its stages another family"):
        Catalog().add_file(path)


def test_two_adapters_of_one_type_and_direction_are_told_with_both_origins(tmp_path: Path) -> None:
    one, two = plugin(tmp_path, "[Read, Write]"), plugin(tmp_path, "[Read]", file="other.py")
    said = refused(one, two)
    assert said == "'test.stop_t' is read by adapters of mine.py and of other.py\n  fix the plugin"


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ("3", "graphnav_adapters() does not return a list\n  return [MyAdapter()]"),
        ("[Twist]", "graphnav_adapters() returns <class 'graphnav.messages.driving.Twist'>, which is not an Adapter"),
        ("[Adapter]", "adapter Adapter does not name its type: write type_name = 'package.type_t'"),
        ("[type('Half', (Adapter,), {'type_name': 'a.b_t'})]", "adapter Half has no lcm_class that lcm-gen made"),
        (
            "[type('Half', (Adapter,), {'type_name': 'a.b_t', 'lcm_class': graphnav_lcm.stop_t})]",
            "adapter Half does not name its message: write message = Image, or another Message",
        ),
        (
            "[type('Half', (Adapter,), {'type_name': 'a.b_t', 'lcm_class': graphnav_lcm.stop_t, 'message': Stop})]",
            "adapter Half has neither from_lcm nor to_lcm",
        ),
        (
            "[type('Bad', (Read,), {'__init__': lambda self: 1 / 0})]",
            "Bad() raises ZeroDivisionError: division by zero",
        ),
        ("1 / 0", "graphnav_adapters() failed: ZeroDivisionError: division by zero"),
    ],
)
def test_what_is_not_an_adapter_is_told(tmp_path: Path, given: str, said: str) -> None:
    assert refused(plugin(tmp_path, given)).startswith(f"mine.py: {said}")
