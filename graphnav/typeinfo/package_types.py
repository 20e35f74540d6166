"""LCM types of an installed package that lcm-gen generated."""

from __future__ import annotations

import importlib
import inspect
import pkgutil
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

from graphnav.codec import lcm_name
from graphnav.errors import Place, UserError, one_line

_HEADERS = (b'"""LCM type definitions', b'"""LCM package __init__.py')
"""How lcm-gen begins what it writes; nothing else in a package is imported."""


def types_of_package(name: str) -> dict[str, type]:
    """Return the lcm-gen classes of a package and of the packages in it, by the name that each has in LCM.

    Raises
    ------
    UserError
        There is no such package, it cannot be imported, or lcm-gen did not generate it.
    """
    package = _import(name)
    modules = [package, *_generated_modules(package)]
    members = (member for module in modules for _, member in inspect.getmembers(module, inspect.isclass))
    found = {lcm_name(member): member for member in members if hasattr(member, "__typenames__")}
    if not found:
        raise UserError.of(
            f"the package '{name}' holds no LCM types", "name a package that lcm-gen -p wrote", Place("--types")
        )
    return found


def _import(name: str) -> ModuleType:
    try:
        return importlib.import_module(name)
    except ModuleNotFoundError as error:
        if error.name is not None and (name == error.name or name.startswith(f"{error.name}.")):
            what = f"there is no folder, file or installed package '{name}'"
            hint = "name a folder of .lcm files, or a package that lcm-gen -p wrote; PYTHONPATH finds others"
            raise UserError.of(what, hint, Place("--types")) from error
        raise _broken(name, error) from error
    except (Exception, SystemExit) as error:
        raise _broken(name, error) from error


def _broken(name: str, error: BaseException) -> UserError:
    return UserError.of(f"the package '{name}' cannot be imported: {one_line(error)}", place=Place("--types"))


def _generated_modules(package: ModuleType) -> Iterator[ModuleType]:
    for info in pkgutil.iter_modules(getattr(package, "__path__", ())):
        name = f"{package.__name__}.{info.name}"
        if not _is_generated(package, info):
            continue
        module = _import(name)
        yield module
        if info.ispkg:
            yield from _generated_modules(module)


def _is_generated(package: ModuleType, info: pkgutil.ModuleInfo) -> bool:
    for folder in map(Path, package.__path__):
        path = folder / info.name / "__init__.py" if info.ispkg else folder / f"{info.name}.py"
        try:
            with path.open("rb") as file:
                return file.read(64).startswith(_HEADERS)
        except OSError:
            continue
    return False
