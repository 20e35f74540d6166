"""Find a study by file or name, and distinguish it from a graph."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

from graphnav import Place, UserError, Value, shown_path
from graphnav.core.graph import find_graph, shipped_folder, shipped_graphs, suggest_graph
from graphnav.core.spec import keys_of, parse_yaml, read_bytes
from graphnav.studies.ablation.study.study_keys import StudyKeys

_ONLY_IN_STUDIES = (keys_of(StudyKeys).keys() | StudyKeys.renamed.keys()) - {"about"}


def shipped_studies() -> dict[str, Path]:
    """Return the studies that ship, by name."""
    return {path.stem: path for path in sorted((shipped_folder() / "studies").glob("*.yaml"))}


def find(name: str | Path) -> Path:
    """Return the file of a study or a graph: in the working folder, else a study that ships, else a graph that ships.

    Raises
    ------
    UserError
        There is none.
    """
    studies = shipped_studies()
    try:
        path = find_graph(name)
    except UserError:
        if str(name) in studies:
            return studies[str(name)]
        if _is_folder(Path(name)):
            raise
        near = sorted(str(p) for suffix in ("yaml", "yml") for p in Path().glob(f"*.{suffix}"))
        hint = suggest_graph(str(name), {*studies, *shipped_graphs(), *near})
        known = f"studies that ship: {', '.join(studies)}\ngraphs that ship: {', '.join(shipped_graphs())}"
        raise UserError.of("there is no such study or graph", hint or known, Place(str(name))) from None
    is_shipped_graph = path == shipped_graphs().get(str(name))
    return studies.get(str(name), path) if is_shipped_graph else path


def read(path: Path) -> bytes:
    """Return the bytes of a file, one more than a study may have if there are more.

    Raises
    ------
    UserError
        It cannot be read.
    """
    return read_bytes(path, Place(shown_path(path)))


def kind_of(value: Value) -> Literal["study", "graph"]:
    """Return the kind of a file by its keys: a study varies something, a graph has stages."""
    words = value.data
    if not isinstance(words, dict) or "vary" in words:
        return "study"
    return "study" if "stages" not in words and _ONLY_IN_STUDIES & words.keys() else "graph"


def classify(name: str | Path) -> Literal["study", "graph"]:
    """Return whether a file or a name means a study or a graph.

    Raises
    ------
    UserError
        There is no such file, or it is not YAML.
    """
    path = find(name)
    return kind_of(parse_yaml(read(path), shown_path(path))[0])


def _is_folder(path: Path) -> bool:
    try:
        return path.is_dir()
    except OSError:  # a name too long
        return False
