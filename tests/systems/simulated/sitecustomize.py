"""Let graphnav see another system than Linux, in every process that has this folder in its ``PYTHONPATH``.

``GRAPHNAV_TEST_SYSTEM`` names the file that says which one: its ``sys.platform``, ``os.name``, and the modules and
names that it lacks. Only graphnav's own imports are answered so: the standard library and other packages cannot be
loaded as those of another system. Files below ``/proc`` cannot be opened by any code, and with the file's
``keeps_open`` no open file be removed or renamed, as on Windows. What Windows has instead of what it lacks stands in
for it by that of Linux.

Not simulated: paths with backslashes and drives, text in code pages of the console, Windows' own libraries and calls.
"""

from __future__ import annotations

import builtins
import fcntl
import json
import multiprocessing.connection
import os
import signal
import subprocess
import sys
from types import ModuleType, SimpleNamespace
from typing import Any

_WITH_FILES = {"os.remove", "os.rename", "os.rmdir"}
_FDS = "/proc/self/fd"
_OF_OTHERS = "/proc/self/maps"
"""Read by threadpoolctl, which asks other systems in other ways."""


class View(ModuleType):
    """A module without some of its names, and with others; what is set in it is set in the module."""

    def __init__(self, module: ModuleType, lacks: set[str], has: dict[str, Any]) -> None:
        super().__init__(module.__name__)
        self.__dict__.update(_module=module, _lacks=lacks, _has=has)

    def __getattr__(self, name: str) -> Any:
        if name in self._has:
            return self._has[name]
        if name in self._lacks:
            raise AttributeError(f"module '{self.__name__}' has no attribute '{name}' on this system", name=name)
        return getattr(self._module, name)

    def __setattr__(self, name: str, value: Any) -> None:
        setattr(self._module, name, value)


def _locking(fd: int, mode: int, n_bytes: int) -> None:
    """Stand in for `msvcrt.locking`, as it is documented."""
    assert n_bytes == 1
    try:
        fcntl.flock(fd, fcntl.LOCK_EX if mode == _MSVCRT.LK_LOCK else fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError as error:
        raise PermissionError(13, "Permission denied") from error


class _StartUpInfo:
    """Stands in for `subprocess.STARTUPINFO`."""

    def __init__(self, *, lpAttributeList: dict[str, list[int]]) -> None:
        self.handles = lpAttributeList["handle_list"]


def _popen(command: list[str], *, startupinfo: _StartUpInfo, creationflags: int, **options: Any) -> Any:
    """Stand in for `subprocess.Popen`: handles of the list are inherited if they may be."""
    assert creationflags == _NEW_GROUP
    assert all(map(os.get_inheritable, startupinfo.handles))
    return subprocess.Popen(command, pass_fds=startupinfo.handles, **options)


_NEW_GROUP = 0x200
_MSVCRT = ModuleType("msvcrt")
_MSVCRT.__dict__.update(locking=_locking, LK_LOCK=1, LK_NBLCK=2)
_OF_WINDOWS: dict[str, dict[str, Any]] = {
    "os": {"set_handle_inheritable": os.set_inheritable, "O_BINARY": 0},
    "signal": {"SIGBREAK": signal.SIGHUP},
    "subprocess": {"STARTUPINFO": _StartUpInfo, "CREATE_NEW_PROCESS_GROUP": _NEW_GROUP, "Popen": _popen},
    "multiprocessing.connection": {"PipeConnection": multiprocessing.connection.Connection},
}


def simulate(platform: str, os_name: str, modules: list[str], names: dict[str, list[str]], *, keeps_open: bool) -> None:
    """Answer graphnav's imports as a system does, and refuse what it would."""
    windows = _OF_WINDOWS if platform == "win32" else {}
    has = {name: dict(windows.get(name, {})) for name in {"sys", "os", *names, *windows}}
    has["sys"]["platform"], has["os"]["name"] = platform, os_name
    views: dict[str, ModuleType] = {
        name: View(__import__(name, fromlist=["*"]), set(names.get(name, [])), found) for name, found in has.items()
    }
    if windows:
        views["msvcrt"] = _MSVCRT
    usual = builtins.__import__

    def imported(name: str, *args: Any, **options: Any) -> Any:
        given = dict(zip(("globals", "locals", "fromlist", "level"), args, strict=False)) | options
        of, fromlist, level = given.get("globals") or {}, given.get("fromlist"), given.get("level", 0)
        package = str(of.get("__package__") or of.get("__name__") or "")
        if level == 0 and package.startswith("graphnav"):
            if name.partition(".")[0] in modules:
                raise ModuleNotFoundError(f"No module named '{name}' on this system", name=name)
            if name in views and (fromlist or "." not in name):
                return views[name]
        return usual(name, *args, **options)

    builtins.__import__ = imported
    looking = SimpleNamespace(is_on=False)

    def refuse(event: str, args: tuple[Any, ...]) -> None:
        if looking.is_on or not args or not isinstance(args[0], str | bytes):
            return
        path = os.fsdecode(args[0])
        if event in {"open", "os.listdir", "os.scandir"} and path.startswith("/proc/") and path != _OF_OTHERS:
            raise FileNotFoundError(2, "No such file or directory", path)
        if keeps_open and event in _WITH_FILES:
            looking.is_on = True
            try:
                folder = f"{_FDS}/{args[-1]}" if isinstance(args[-1], int) and args[-1] >= 0 else ""
                if os.path.realpath(os.path.join(folder, path)) in _open_files():
                    raise PermissionError(13, "The process cannot access the file: it is open", path)
            finally:
                looking.is_on = False

    sys.addaudithook(refuse)


def _open_files() -> set[str]:
    """Return the files that this process has open."""
    found = set()
    for fd in os.listdir(_FDS):
        try:
            found.add(os.readlink(f"{_FDS}/{fd}"))
        except OSError:
            continue
    return found


if "GRAPHNAV_TEST_SYSTEM" in os.environ:
    with open(os.environ["GRAPHNAV_TEST_SYSTEM"], encoding="utf-8") as _file:
        simulate(**json.load(_file))
