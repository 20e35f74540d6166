"""Register LCM types of other packages for decoding: ``--types``."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path

from graphnav.core.codec import add_type
from graphnav.core.errors import Place, UserError
from graphnav.core.typeinfo.compile_definitions import compile_definitions
from graphnav.core.typeinfo.package_types import types_of_package


def load_types(names: Iterable[str]) -> dict[str, type]:
    """Register types and return their classes by LCM name.

    A name is a ``.lcm`` file, a folder that holds such files (at any depth), or an installed package that lcm-gen
    generated. All files are compiled together, so that they may use each other's types.

    Raises
    ------
    UserError
        A name is none of these, or its types cannot be used; with file and line if a definition is wrong.
    GraphnavError
        LCM's tools are not installed.
    """
    packages: list[str] = []
    files: dict[Path, Path] = {}
    for name in dict.fromkeys(names):
        if _is(Path(name).is_dir) and (found := _definitions_in(Path(name))):
            files |= {path.resolve(): path for path in found}
        elif name.endswith(".lcm") and _is(Path(name).exists):
            files[Path(name).resolve()] = Path(name)
        elif all(part.isidentifier() for part in name.split(".")) and not name.endswith(".lcm"):
            packages.append(name)
        else:
            raise _nothing(name)
    loaded: dict[str, type] = {}
    for package in packages:
        loaded |= _add(types_of_package(package))
    if files:
        compiled = compile_definitions(list(files.values()))
        if not compiled:
            raise UserError.of(f"no types are defined in {', '.join(map(str, files.values()))}", place=Place("--types"))
        loaded |= _add(compiled)
    return loaded


def _definitions_in(folder: Path) -> list[Path]:
    return sorted(path for path in folder.rglob("*.lcm") if path.is_file())


def _add(types: dict[str, type]) -> dict[str, type]:
    for name, lcm_class in types.items():
        add_type(name, lcm_class)
    return types


def _nothing(name: str) -> UserError:
    if name and _is(Path(name).is_dir):
        hint = "name one that does"
        if _is((Path(name) / "__init__.py").is_file):
            package = Path(name).resolve()
            hint = f"for its Python set PYTHONPATH={package.parent} and write --types {package.name}"
        return UserError.of(f"the folder '{name}' holds no .lcm files", hint, Place("--types"))
    if _is(Path(name).is_file):
        return UserError.of(f"'{name}' is not a .lcm file", "name a .lcm file or a folder of them", Place("--types"))
    return UserError.of(
        f"there is no folder, file or installed package '{name}'", "name a folder of .lcm files", Place("--types")
    )


def _is(question: Callable[[], bool]) -> bool:
    try:
        return question()
    except (OSError, ValueError):  # the name is too long, or has a null character
        return False
