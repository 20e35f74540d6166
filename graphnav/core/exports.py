"""Export the names of a package, each imported on first use, as its ``__init__.pyi`` lists them.

Type checkers read that file; here its imports are read by a pattern, at the first use of a name, because ``ast`` and
what needs it take as long to load as all of ``graphnav --help``. A name is hidden by a module that is called the same.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Callable
from importlib import import_module

_IMPORT = re.compile(r"^from (\.\S+) import (?:\(([^)]*)\)|(.*))$", re.MULTILINE)
_NAME = re.compile(r"\w+")


def exports(package: str, file: str, *defined: str) -> tuple[Callable[[str], object], Callable[[], list[str]]]:
    """Return ``__getattr__`` and ``__dir__`` of the package whose ``__init__.py`` is ``file``.

    ``defined``: names that ``__init__.py`` itself defines. ``__all__`` is an attribute, too.
    """
    homes: dict[str, str] = {}

    def read() -> dict[str, str]:
        """Return the module of each name, relative to the package."""
        if not homes:
            with open(f"{file}i", encoding="utf-8") as stub:
                text = stub.read()
            for module, many, few in _IMPORT.findall(text):
                for part in (many or few).split(","):
                    if name := _NAME.search(part):
                        homes[name[0]] = module
        return homes

    def attribute(name: str) -> object:
        if name == "__all__":
            return names()
        module = read().get(name)
        if module is None:
            raise AttributeError(f"module '{package}' has no attribute '{name}'", name=name)
        value = getattr(import_module(module, package), name)
        setattr(sys.modules[package], name, value)  # the next use finds it without asking here
        return value

    def names() -> list[str]:
        return [*defined, *read()]

    return attribute, names
