"""The catalog: the installed stage classes, by ``family.stage``."""

from __future__ import annotations

import importlib.util
import re
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import suppress
from importlib.machinery import SourceFileLoader
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from traceback import extract_tb
from types import ModuleType
from typing import Any, get_args

import pluggy

import graphnav.core.hooks
from graphnav.core.adapter import Adapters, collect_adapters
from graphnav.core.errors import (
    CatalogError,
    DeclarationError,
    Hint,
    ParamError,
    did_you_mean,
    fix_the_plugin,
    message_line,
    one_line,
    raised_line,
    shown_value,
)
from graphnav.core.interrupts import CtrlC, third_party_code
from graphnav.core.messages import Message, snake_case
from graphnav.core.stage import FormerNames, Port, Role, Source, Stage, metrics_of, params_of, ports_of
from graphnav.core.trust import Trust, read_plugin

GROUP = "graphnav"
"""Entry point group: the name of an entry point is a family, or ``family.part``, its value a module with hooks."""

ADAPTERS = "adapters"
"""Reserved family of packages that provide adapters, which any graph with inputs or outputs may use."""

OWN = "graphnav"
"""The distribution whose families come with graphnav."""

_NAME = re.compile(r"[a-z][a-z0-9_]*")


def family_of(point: EntryPoint) -> str:
    """Return the family of a package: a distribution with several packages of one family names them ``family.part``."""
    return point.name.partition(".")[0]


class Catalog:
    """Finds stage classes; imports only the requested families.

    ``trust``: which plugin files may run that graphs name; by default what the user has trusted before.
    """

    def __init__(self, trust: Trust | None = None) -> None:
        self.trust = trust or Trust()
        self._plugins = pluggy.PluginManager(graphnav.core.hooks.PROJECT)
        self._plugins.add_hookspecs(graphnav.core.hooks)
        self._entry_points: dict[str, list[EntryPoint]] = {}
        self._stages: dict[str, dict[str, type[Stage]]] = {}
        self._origins: dict[str, str] = {}
        self._files: dict[str, list[str]] = {}
        self._loaded: set[str] = set()
        self._registered: set[str] = set()
        self._declared: set[str] = set()
        """Stages whose declaration is right."""
        self._adapters: Adapters | None = None
        for point in sorted(entry_points(group=GROUP), key=lambda p: (p.name, p.value)):
            self._entry_points.setdefault(family_of(point), []).append(point)

    @property
    def hook(self) -> pluggy.HookRelay:
        """The hooks of all loaded families and files."""
        return self._plugins.hook

    def families(self) -> tuple[str, ...]:
        """Return the names of all families of stages, imported or not, sorted."""
        files = {family for family in self._files if family in self._entry_points or self._stages.get(family)}
        return tuple(sorted({*self._entry_points, *files} - {ADAPTERS}))

    def adapters(self) -> Adapters:
        """Return the adapters of the family ``adapters`` and of all loaded families and files.

        Raises
        ------
        CatalogError
            A package cannot be imported, or its hook returns something that is not an adapter, or a duplicate.
        """
        if ADAPTERS in self._entry_points:
            self._load(ADAPTERS)
        if self._adapters is None:
            try:
                self._adapters = collect_adapters(self._given_adapters())
            except DeclarationError as error:
                raise CatalogError(str(error), "fix the plugin") from error
        return self._adapters

    def load_types(self) -> None:
        """Import the adapters and the families of other packages, which registers their messages and LCM types.

        What cannot be imported is left out. The families of graphnav itself define no types.
        """
        with suppress(CatalogError):
            self.adapters()
        for family, points in self._entry_points.items():
            if family != ADAPTERS and any(point.dist is None or point.dist.name != OWN for point in points):
                with suppress(CatalogError):
                    self.load(family)

    def names(self, family: str) -> tuple[str, ...]:
        """Return the names of a family's stages, sorted.

        Raises
        ------
        CatalogError
            The family does not exist, or one of its packages cannot be used.
        """
        self.load(family)
        return tuple(sorted(self._stages.get(family, {})))

    def stage(self, use: str) -> type[Stage]:
        """Return the class that ``family.stage`` names.

        Raises
        ------
        CatalogError
            The stage does not exist, its declaration is wrong, or a package of its family cannot be used.
        """
        family, dot, name = use.partition(".")
        if use in self._declared:
            return self._stages[family][name]
        if not dot:
            raise CatalogError(f"'{use}' does not name a stage", self._hint_without_family(use))
        if family not in self.families():
            hint = did_you_mean(family, self.families()) or f"families are {', '.join(self.families())}"
            raise CatalogError(f"there is no family '{family}'", hint)
        names = self.names(family)
        if name not in names:
            hint = did_you_mean(name, names) or (f"it has {', '.join(names)}" if names else "it has no stages")
            raise CatalogError(f"family '{family}' has no stage '{name}'", hint)
        cls = self._stages[family][name]
        self.called(
            self._origins[use], f"the declaration of {use}", lambda: _check_declaration(cls, self._origins[use])
        )
        self._declared.add(use)
        return cls

    def stage_with_ports(self, use: str, params: Mapping[str, Any]) -> type[Stage]:
        """Return the class of a stage whose parameters ``params`` declare its ports (`Stage.ports_from`).

        Raises
        ------
        CatalogError
            As of `stage`; or the stage's code raises, or the class that it makes is not one of a stage.
        ParamError, ExceptionGroup
            The parameters declare no ports; a group holds `ParamError` alone.
        """
        cls, origin, refused = self.stage(use), self._origins[use], list[ParamError | ExceptionGroup[Any]]()

        def make() -> type[Stage]:
            try:
                made = cls.with_ports(**params)
            except ParamError as error:
                refused.append(error)
                return cls
            except ExceptionGroup as error:
                if error.split(ParamError)[1] is not None:
                    raise
                refused.append(error)
                return cls
            _check_declaration(made, origin)
            return made

        made: type[Stage] = self.called(origin, f"with_ports() of {use}", make)
        if refused:
            raise refused[0]
        return made

    def has(self, use: str) -> bool:
        """Return whether a loaded family or file has this stage."""
        return use in self._origins

    def ports(self, message: type[Message]) -> Iterator[tuple[str, Port, bool]]:
        """Yield ``family.stage`` and the port of every installed stage that writes or reads a message type.

        The flag says whether it writes it. What cannot be imported is left out.
        """
        for family in self.families():
            with suppress(CatalogError):
                for use in (f"{family}.{name}" for name in self.names(family)):
                    ports = ports_of(self.stage(use))
                    yield from ((use, port, True) for port in ports.outputs if port.message is message)
                    yield from ((use, port, False) for port in ports.inputs if port.message is message)

    def writers(self, message: type[Message]) -> list[str]:
        """Return the installed stages that write a message type and that a stage may read."""
        writers = dict.fromkeys(use for use, _, is_output in self.ports(message) if is_output)
        return [use for use in writers if self.stage(use).role != "score"]

    def origin(self, use: str) -> str:
        """Return the package or file that a loaded stage comes from."""
        return self._origins[use]

    def load(self, family: str) -> None:
        """Import the packages of a family.

        Raises
        ------
        CatalogError
            The family does not exist, or one of its packages cannot be used.
        """
        if family not in self._loaded and family not in self.families():
            raise CatalogError(f"there is no family '{family}'", did_you_mean(family, self.families()))
        self._load(family)

    def _load(self, family: str) -> None:
        if family in self._loaded:
            return
        for point in self._entry_points.get(family, []):
            origin = f"package {point.dist.name}" if point.dist else f"module {point.value}"
            try:
                with third_party_code():
                    module = point.load()
            except CtrlC:
                raise
            except BaseException as error:
                what = f"family '{family}' cannot be imported from {origin}: {one_line(error)}"
                raised = raised_line(error, [point.module])
                hint = "fix the package, or install its dependencies" + (f": {raised}" if raised else "")
                raise CatalogError(what, hint, error) from error
            self._register(family, module, origin)
        self._loaded.add(family)

    def holds_file(self, path: Path) -> bool:
        """Return whether a one-file plugin was added, by any path."""
        return any(str(path.resolve()) in files for files in self._files.values())

    def add_files(self, paths: Iterable[Path]) -> Catalog:
        """Add one-file plugins; return this catalog.

        Raises
        ------
        CatalogError
            A file cannot be used.
        """
        for path in paths:
            self.add_file(path)
        return self

    def add_file(self, path: Path, source: bytes | None = None) -> str:
        """Add the stages of a one-file plugin; return its family: its constant ``FAMILY``, else the file's stem.

        Adding the same file again, by any path, has no effect. ``source``: its content, if it was read already.

        Raises
        ------
        CatalogError
            It cannot be read, imported or used.
        """
        file = _real_file(path)
        for known, files in self._files.items():
            if file in files:
                return known
        module = _import_file(path, source)
        family = getattr(module, "FAMILY", path.stem)
        if not isinstance(family, str) or not _NAME.fullmatch(family):
            raise CatalogError(
                f"plugin {path}: {shown_value(family)} cannot be a family: it must match {_NAME.pattern}",
                "write FAMILY = '...' in the file",
            )
        if family in self._entry_points:
            self._load(family)
        self._register(family, module, str(path))
        if not self._plugins.get_hookcallers(module):
            hint = "write @hookimpl above def graphnav_stages() -> list[type[Stage]]"
            raise CatalogError(f"plugin {path}: it has no hook", hint)
        self._files.setdefault(family, []).append(file)
        self._loaded.add(family)
        return family

    def _register(self, family: str, module: ModuleType, origin: str) -> None:
        key = f"{family}, {module.__name__}: {origin}"
        if key in self._registered:
            return
        if not self._plugins.is_registered(module):
            try:
                self._plugins.register(module, name=key)
                self._plugins.check_pending()
            except pluggy.PluginValidationError as error:
                raise CatalogError(f"{origin}: {message_line(error)}") from error
        self._adapters = None
        stages = {snake_case(cls.__name__): cls for cls in self._stages_of(module, origin)}
        if family == ADAPTERS and stages:
            raise CatalogError(f"{origin}: the family '{ADAPTERS}' is reserved", "give its stages another family")
        for name in stages:
            use = f"{family}.{name}"
            if use in self._origins:
                raise CatalogError(f"'{use}' comes from {self._origins[use]} and from {origin}", "remove or rename one")
            self._origins[use] = origin
        self._stages.setdefault(family, {}).update(stages)
        self._registered.add(key)

    def _stages_of(self, module: ModuleType, origin: str) -> list[type[Stage]]:
        others: list[Any] = [plugin for plugin in self._plugins.get_plugins() if plugin is not module]
        call = self._plugins.subset_hook_caller("graphnav_stages", others)
        found = self.called(origin, "graphnav_stages()", call)
        if not all(isinstance(classes, list | tuple) for classes in found):
            raise CatalogError(f"{origin}: graphnav_stages() does not return a list", "return [MyStage]")
        stages = [cls for classes in found for cls in classes]
        for cls in stages:
            if not (isinstance(cls, type) and issubclass(cls, Stage)):
                raise CatalogError(
                    f"{origin}: graphnav_stages() returns {shown_value(cls)}, which is not a Stage class"
                )
        return stages

    def _given_adapters(self) -> Iterator[tuple[str, Any]]:
        """Yield each object returned by an adapter hook, with the origin of the hook."""
        for hook in self._plugins.hook.graphnav_adapters.get_hookimpls():
            origin = hook.plugin_name.partition(": ")[2]
            given = self.called(origin, "graphnav_adapters()", hook.function)
            if not isinstance(given, list | tuple):
                raise CatalogError(f"{origin}: graphnav_adapters() does not return a list", "return [MyAdapter()]")
            yield from ((origin, adapter) for adapter in given)

    @staticmethod
    def called(origin: str, name: str, call: Callable[[], Any]) -> Any:
        """Return what a plugin's code returns; raises CatalogError for whatever it raises.

        ``origin``: the plugin; ``name``: what is called.
        """
        try:
            with third_party_code():
                return call()
        except (CatalogError, CtrlC):
            raise
        except BaseException as error:
            what = f"{origin}: {name} failed: {one_line(error)}"
            raise CatalogError(what, fix_the_plugin(error), error) from error

    def _hint_without_family(self, word: str) -> str:
        if word in self.families():
            names = ", ".join(f"{word}.{name}" for name in self.names(word))
            return f"write one of {names}" if names else f"family '{word}' has no stages"
        for family in self.families():
            try:
                if word in self.names(family):
                    return f"write '{family}.{word}'"
            except CatalogError:
                continue
        return "write family.stage, as 'graphnav stages' lists them"


def _check_role(cls: type[Stage], origin: str) -> None:
    role: object = cls.role
    if role in get_args(Role):
        return
    near = did_you_mean(role, get_args(Role), FormerNames.ROLES) if isinstance(role, str) else ""
    shown = f"'{role}'" if isinstance(role, str) else f"a {type(role).__name__}"
    hint = near or f"roles are {', '.join(get_args(Role))}"
    raise CatalogError(f"{origin}: the role of {cls.__qualname__} is {shown}", hint)


def _check_declaration(cls: type[Stage], origin: str) -> None:
    try:
        params_of(cls)
        metrics_of(cls)
        plain = [port.name for port in ports_of(cls).inputs if port.is_plain]
    except DeclarationError as error:
        raise CatalogError(f"{origin}: {error}") from error
    _check_role(cls, origin)
    if issubclass(cls, Source) and plain:
        raise CatalogError(
            f"{origin}: {cls.__qualname__} is a Source, but its input '{plain[0]}' is not sampled",
            "annotate it Latest[...], or derive the class from Stage",
        )
    if issubclass(cls, Source):
        _check_reproducible(cls, origin)
    has_ports = not cls.ports_from or bool(ports_of(cls).inputs)
    if has_ports and not issubclass(cls, Source) and all(port.may_be_open for port in ports_of(cls).inputs):
        raise CatalogError(
            f"{origin}: nothing fires {cls.__qualname__}: it is not a Source and all its inputs are sampled",
            "derive it from Source, or annotate an input without Latest",
        )


def _check_reproducible(cls: type[Source], origin: str) -> None:
    names = [port.name for port in ports_of(cls).outputs]
    for name in cls.reproducible:
        if name not in names:
            what = f"{origin}: {cls.__qualname__} names '{name}' as reproducible, which is not an output of its step"
            raise CatalogError(what, did_you_mean(name, names) or f"outputs are {', '.join(names) or 'none'}")
    if names and set(cls.reproducible) == set(names):
        what = f"{origin}: all outputs of {cls.__qualname__} are reproducible: none is left to check what is reproduced"
        raise CatalogError(what, "leave out one of them, which is then recorded")


def _real_file(path: Path) -> str:
    """Return the canonical path of an existing file."""
    try:
        if path.is_file():
            return str(path.resolve())
        what = "is not a file" if path.exists() else "file not found"
        near: Hint = did_you_mean(path.name, (p.name for p in path.parent.glob("*.py")))
    except (OSError, ValueError):  # a name too long, or with a null character
        what, near = "file not found", ""
    raise CatalogError(f"plugin {path}: {what}", near)


def _import_file(path: Path, source: bytes | None) -> ModuleType:
    """Return the module of a file, made from its source: a compiled file beside it might come from elsewhere."""
    name = f"graphnav_plugin_{path.stem}_{len(sys.modules)}"
    spec = importlib.util.spec_from_file_location(name, path)
    if spec is None or not isinstance(spec.loader, SourceFileLoader):
        raise CatalogError(f"plugin {path}: not a Python file", "give it the suffix .py")
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    try:
        code = spec.loader.source_to_code(read_plugin(path) if source is None else source, str(path))
        with third_party_code():
            exec(code, module.__dict__)  # noqa: S102 - the plugin, which the user named or trusts
    except CtrlC:
        raise
    except BaseException as error:
        raise CatalogError(_import_failure(error, path), raised=error) from error
    return module


def _import_failure(error: BaseException, path: Path) -> str:
    """Return what a one-file plugin raised while it was imported, with its line."""
    lines = [line.lineno for line in extract_tb(error.__traceback__) if Path(line.filename).resolve() == path.resolve()]
    what = one_line(error)
    if isinstance(error, SyntaxError) and error.filename and Path(error.filename).resolve() == path.resolve():
        lines, what = [error.lineno], f"{type(error).__name__}: {error.msg}"
    where = f"{path}:{lines[-1]}" if lines and lines[-1] else str(path)
    return f"plugin {where}: {what}"
