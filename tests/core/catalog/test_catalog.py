"""Stages are found by family, only what is asked for is imported, and a plugin that cannot be used is told."""

import subprocess
import sys
from importlib.metadata import EntryPoint
from pathlib import Path

import pytest

import graphnav.core.catalog
from graphnav.core.catalog import Catalog
from graphnav.core.errors import CatalogError, UserError
from graphnav.core.graph import load_graph

STAGE = """\
from graphnav import Image, Stage, hookimpl

class {name}(Stage):
    '''The same picture.'''

    def step(self, image: Image) -> Image:
        return image

@hookimpl
def graphnav_stages() -> list[type[Stage]]:
    return [{name}]
"""


def plugin(folder: Path, text: str, name: str = "my_stage.py") -> Path:
    path = folder / name
    path.write_text(text)
    return path


def refused(path: Path) -> str:
    """Return the error for a file that cannot be used, without its folder."""
    with pytest.raises(CatalogError) as caught:
        Catalog().add_file(path)
    return str(caught.value).replace(f"{path.parent}/", "")


def test_only_the_family_that_is_asked_for_is_imported() -> None:
    code = (
        "import sys; from graphnav.core.catalog import Catalog; Catalog().stage('plane.affine');"
        "print([m for m in ('graphnav_flow', 'graphnav_world', 'pymunk') if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "[]\n"


@pytest.mark.parametrize(
    ("role", "message"),
    [
        ("role = 'control'", r"the role of Same is 'control'\n  did you mean 'baseline'\?"),
        ("role = property(lambda self: 'oracle')", r"the role of Same is a property\n  roles are method, baseline"),
        ("role = ['oracle']", r"the role of Same is a list\n  roles are method, baseline"),
    ],
)
def test_a_role_that_is_not_one_is_told(tmp_path: Path, role: str, message: str) -> None:
    text = STAGE.format(name="Same").replace("    def step", f"    {role}\n\n    def step")
    catalog = Catalog()
    catalog.add_file(plugin(tmp_path, text))
    with pytest.raises(CatalogError, match=message):
        catalog.stage("my_stage.same")


def test_the_family_of_a_file_is_its_constant_or_else_its_stem(tmp_path: Path) -> None:
    catalog = Catalog()
    assert catalog.add_file(plugin(tmp_path, STAGE.format(name="Same"))) == "my_stage"
    text = STAGE.format(name="Same") + "\nFAMILY = 'flow'\n"
    assert catalog.add_file(plugin(tmp_path, text, "other.py")) == "flow"
    assert catalog.stage("my_stage.same").__name__ == "Same"
    assert {"same", "lucas_kanade"} <= set(catalog.names("flow"))
    assert catalog.origin("flow.same") == str(tmp_path / "other.py")


def test_the_same_stage_twice_is_told_with_both_places(tmp_path: Path) -> None:
    catalog = Catalog()
    one = plugin(tmp_path, "FAMILY = 'mine'\n" + STAGE.format(name="Same"), "one.py")
    two = plugin(tmp_path, "FAMILY = 'mine'\n" + STAGE.format(name="Same"), "two.py")
    catalog.add_file(one)
    with pytest.raises(CatalogError) as caught:
        catalog.add_file(two)
    assert str(caught.value) == f"'mine.same' comes from {one} and from {two}\n  remove or rename one"


def test_the_same_file_twice_is_the_same_as_once(tmp_path: Path) -> None:
    catalog = Catalog()
    path = plugin(tmp_path, STAGE.format(name="Same"))
    assert catalog.add_file(path) == catalog.add_file(path) == "my_stage"
    assert catalog.names("my_stage") == ("same",)


def test_names_of_classes_become_names_of_stages(tmp_path: Path) -> None:
    catalog = Catalog()
    catalog.add_file(plugin(tmp_path, STAGE.format(name="PCASteering2D")))
    assert catalog.names("my_stage") == ("pca_steering2_d",)


def test_a_missing_file(tmp_path: Path) -> None:
    plugin(tmp_path, "")
    assert refused(tmp_path / "my_stag.py") == "plugin my_stag.py: file not found\n  did you mean 'my_stage.py'?"


def test_a_file_that_is_no_python(tmp_path: Path) -> None:
    assert refused(plugin(tmp_path, "", "stages.txt")).startswith("plugin stages.txt: not a Python file")


def test_a_syntax_error_has_its_line(tmp_path: Path) -> None:
    assert refused(plugin(tmp_path, "x = 1\ndef\n")) == "plugin my_stage.py:2: SyntaxError: invalid syntax"


def test_an_error_on_import_has_its_line(tmp_path: Path) -> None:
    said = refused(plugin(tmp_path, "\nimport no_such_module\n"))
    assert said == "plugin my_stage.py:2: ModuleNotFoundError: No module named 'no_such_module'"


def test_a_file_that_ends_the_program_is_told(tmp_path: Path) -> None:
    assert refused(plugin(tmp_path, "import sys\nsys.exit(3)\n")) == "plugin my_stage.py:2: SystemExit: 3"


def test_a_file_without_a_hook(tmp_path: Path) -> None:
    assert refused(plugin(tmp_path, "x = 1\n")) == (
        "plugin my_stage.py: it has no hook\n  write @hookimpl above def graphnav_stages() -> list[type[Stage]]"
    )


def test_a_hook_without_its_mark(tmp_path: Path) -> None:
    assert "it has no hook" in refused(plugin(tmp_path, "def graphnav_stages():\n    return []\n"))


def test_a_hook_without_a_caller(tmp_path: Path) -> None:
    text = "from graphnav import hookimpl\n@hookimpl\ndef graphnav_stags():\n    return []\n"
    assert "graphnav_stags" in refused(plugin(tmp_path, text))


@pytest.mark.parametrize(
    ("body", "said"),
    [
        ("return 3", "graphnav_stages() does not return a list\n  return [MyStage]"),
        ("return [3]", "graphnav_stages() returns 3, which is not a Stage class"),
        (
            "raise OSError('no disk')",
            "graphnav_stages() failed: OSError: no disk\n  fix the plugin: OSError at my_stage.py:4 in graphnav_stages",
        ),
    ],
)
def test_a_hook_that_returns_something_else(tmp_path: Path, body: str, said: str) -> None:
    text = f"from graphnav import hookimpl\n@hookimpl\ndef graphnav_stages():\n    {body}\n"
    assert refused(plugin(tmp_path, text)) == f"my_stage.py: {said}"


def test_a_constructor_that_raises_is_told_at_its_stage(tmp_path: Path) -> None:
    text = STAGE.format(name="Same").replace(
        "def step", "def check(self):\n        raise OSError('no such port')\n    def step"
    )
    path = plugin(
        tmp_path,
        "from graphnav import Source\n" + text.replace("self, image: Image", "self").replace("(Stage)", "(Source)"),
    )
    (tmp_path / "g.yaml").write_text("stages:\n  a: {use: my_stage.same}\n")
    catalog = Catalog()
    catalog.add_file(path)
    with pytest.raises(UserError) as caught:
        load_graph(tmp_path / "g.yaml", catalog).make_stages()
    assert str(caught.value).replace(f"{tmp_path}/", "") == (
        "g.yaml:2:3: my_stage.same cannot be made: OSError: no such port\n"
        "  fix the plugin: OSError at my_stage.py:8 in check"
    )


def test_a_stem_that_cannot_be_a_family(tmp_path: Path) -> None:
    said = refused(plugin(tmp_path, STAGE.format(name="Same"), "My-Stage.py"))
    assert said.startswith("plugin My-Stage.py: 'My-Stage' cannot be a family")
    assert said.endswith("write FAMILY = '...' in the file")


def test_a_package_that_cannot_be_imported_spoils_only_its_own_family(monkeypatch: pytest.MonkeyPatch) -> None:
    points = [
        EntryPoint("broken", "no_such_package", "graphnav"),
        EntryPoint("flow", "graphnav_flow", "graphnav"),
    ]
    monkeypatch.setattr(graphnav.core.catalog, "entry_points", lambda **_: points)
    catalog = Catalog()
    for _ in range(2):
        with pytest.raises(CatalogError, match="family 'broken' cannot be imported from module no_such_package"):
            catalog.stage("broken.stage")
    assert catalog.stage("flow.dis").__name__ == "Dis"


def test_one_package_may_serve_two_families(monkeypatch: pytest.MonkeyPatch) -> None:
    points = [EntryPoint(name, "graphnav_flow", "graphnav") for name in ("flow", "current")]
    monkeypatch.setattr(graphnav.core.catalog, "entry_points", lambda **_: points)
    catalog = Catalog()
    assert catalog.stage("current.dis") is catalog.stage("flow.dis")


@pytest.mark.parametrize(
    ("declared", "said"),
    [
        (("imag",), "Same names 'imag' as reproducible, which is not an output of its step\n  did you mean 'image'?"),
        (
            ("image",),
            """all outputs of Same are reproducible: none is left to check what is reproduced
  leave out one of them, which is then recorded""",
        ),
    ],
)
def test_reproducible_outputs_are_checked(tmp_path: Path, declared: tuple[str, ...], said: str) -> None:
    text = STAGE.format(name="Same").replace("self, image: Image", "self").replace("(Stage)", "(Source)")
    text = text.replace("    def step", f"    reproducible = {declared}\n    def step")
    catalog = Catalog()
    catalog.add_file(plugin(tmp_path, f"from graphnav import Source\n{text}"))
    with pytest.raises(CatalogError) as caught:
        catalog.stage("my_stage.same")
    assert str(caught.value).endswith(f"my_stage.py: {said}")
