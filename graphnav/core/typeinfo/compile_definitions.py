"""Compile ``.lcm`` files by lcm-gen and import them under a unique package name."""

from __future__ import annotations

import importlib
import importlib.util
import sys
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from graphnav.core.codec import codec_of, fingerprint, type_named
from graphnav.core.codec.layout import PRIMITIVES, hide_prefix
from graphnav.core.errors import Place, Problem, UserError, one_line
from graphnav.core.interrupts import CtrlC
from graphnav.core.typeinfo.definition_source import DefinitionSource, read_definition
from graphnav.core.typeinfo.describe import definition_files
from graphnav.core.typeinfo.lcm_gen import GeneratedModule, generate_python, read_generated


def compile_definitions(paths: Sequence[Path]) -> dict[str, type]:
    """Return the lcm-gen classes of all types that ``.lcm`` files define, by LCM name.

    Types that they use but do not define are taken from shipped or installed packages. The Python code is written to a
    temporary folder and imported as part of a package named like that folder, so that an installed package of the
    same name is neither used nor hidden.

    Raises
    ------
    UserError
        A file cannot be read, lcm-gen or Python rejects it, or it uses an unknown type.
    GraphnavError
        lcm-gen is not installed.
    """
    sources = [read_definition(path) for path in paths]
    with tempfile.TemporaryDirectory(prefix="graphnav_types_") as scratch:
        folder = Path(scratch)
        prefix = folder.name
        modules = _generate(sources, folder / "given", prefix)
        own = frozenset(modules)
        if used := list(_used_elsewhere(modules, prefix, sources)):
            texts = {
                name: text for name, text in definition_files(used).items() if name.removesuffix(".lcm") not in own
            }
            added = [DefinitionSource.of(Path(name), text) for name, text in texts.items()]
            modules = _generate([*sources, *added], folder / "completed", prefix)
            folder /= "completed"
        else:
            folder /= "given"
        found = _import_all(modules, folder / prefix, prefix)
    return {name: lcm_class for name, lcm_class in found.items() if name in own}


def _generate(sources: Sequence[DefinitionSource], folder: Path, prefix: str) -> dict[str, GeneratedModule]:
    """Return the modules that lcm-gen writes into a new folder, by LCM name."""
    folder.mkdir()
    generate_python(sources, folder, prefix)
    root = folder / prefix
    names = {path: ".".join(path.relative_to(root).with_suffix("").parts) for path in sorted(root.rglob("*.py"))}
    return {name: read_generated(path, name) for path, name in names.items() if path.name != "__init__.py"}


def _used_elsewhere(
    modules: Mapping[str, GeneratedModule], prefix: str, sources: Sequence[DefinitionSource]
) -> Iterator[type]:
    """Yield the member types that the files do not define; UserError lists all unknown ones."""
    problems: list[Problem] = []
    for module in modules.values():
        for field, typename in zip(module.slots, module.typenames, strict=True):
            member = typename.removeprefix(f"{prefix}.")
            if typename in PRIMITIVES or member in modules:
                continue
            found = type_named(member)
            if found is not None:
                yield found
                continue
            places = (source.place_of_field(member, field) for source in sources)
            place = next(filter(None, places), Place("--types"))
            what = f"{module.name}.{field} has the type {member}, which is not defined"
            problems.append(Problem(place, what, "also give the folder that defines it: --types DIR"))
    if problems:
        raise UserError(problems)


def _import_all(modules: Mapping[str, GeneratedModule], folder: Path, prefix: str) -> dict[str, type]:
    """Import the packages in ``folder``; return the classes by LCM name."""
    found: dict[str, type] = {}
    if not modules:
        return found
    hide_prefix(f"{prefix}.")
    name = next(iter(modules))
    try:
        _import_package(folder, prefix)
        for name in modules:
            module = importlib.import_module(f"{prefix}.{name}")
            found[name] = lcm_class = getattr(module, name.rpartition(".")[2])
            codec_of(lcm_class)
            fingerprint(lcm_class)
    except CtrlC:
        raise
    except BaseException as error:  # names of fields may clash with members of the class
        what = f"Python cannot hold the type {name}: {one_line(error)}"
        raise UserError.of(what, "rename the field, the type or the package", Place("--types")) from error
    return found


def _import_package(folder: Path, name: str) -> None:
    """Import the outermost package without a search of Python's path."""
    spec = importlib.util.spec_from_file_location(
        name, folder / "__init__.py", submodule_search_locations=[str(folder)]
    )
    assert spec is not None
    assert spec.loader is not None
    package = importlib.util.module_from_spec(spec)
    sys.modules[name] = package
    spec.loader.exec_module(package)
