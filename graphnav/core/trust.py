"""Trust: whether a plugin file that was read about, not named by the user, may run as Python code.

Folders are trusted by their path, once the user has said so. Folders that graphnav writes (runs, studies) are trusted
by their content: the digest of all that stands beside their plugins. Both are kept in the user's state folder.
"""

from __future__ import annotations

import hashlib
import json
import os
import shlex
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

from graphnav.core.errors import GraphnavError, shown_path
from graphnav.core.machine.files import MAX_JSON_BYTES, is_own, read_regular, write_atomically
from graphnav.core.machine.system import lock_file, open_file
from graphnav.core.machine.user_folders import no_user_folder, user_folder
from graphnav.core.notices import print_notice
from graphnav.core.run_folder import RunFolder, is_graph_of_run

MAX_PLUGIN_BYTES = 16 * 1024**2
_MAX_BESIDE = 100
"""How many files may stand beside the plugins of a run."""
_MAX_DIGESTS = 5000
"""How many written folders are remembered, the newest; many folders have the same plugins, and so one digest."""
_FILE = "trust.json"


@dataclass(frozen=True)
class Request:
    """Plugin files that are to run."""

    folder: Path
    """The folder of the graph, the run or the study that names them, resolved."""
    files: tuple[Path, ...]
    digest: str = ""
    """Of a folder that graphnav writes: its content. Empty for any other folder, which is trusted by its path."""

    @staticmethod
    def of(graph: Path, files: Mapping[Path, bytes]) -> Request:
        """Return the request to run the plugin ``files`` that the file ``graph`` names, by the bytes that will run.

        Of a run folder all that a plugin could import counts: what stands beside it.
        """
        folder = graph.parent.resolve()
        digest = Request.digest_of_run(folder, files) if is_graph_of_run(graph) else ""
        return Request(folder, tuple(files), digest)

    @staticmethod
    def of_plan(folder: Path, files: Mapping[Path, bytes]) -> Request:
        """Return the request to run the plugin files that the plan of a study names, by their absolute paths."""
        return Request(folder.resolve(), tuple(files), _digest({str(path): data for path, data in files.items()}))

    @staticmethod
    def digest_of_run(folder: Path, more: Mapping[Path, bytes]) -> str:
        """Return the digest of the plugins in a run folder: all that stands in their folder, and ``more`` files."""
        found = _files_below(folder / RunFolder.PLUGINS) | dict(more)
        return _digest({os.path.relpath(path, folder): data for path, data in found.items()})

    def remember(self) -> str:
        """Remember that files may run from now on; return why that is not possible, empty if it is."""
        if self.digest:
            return _change(lambda known: known.with_digest(self.digest))
        return _change(lambda known: known.with_folder(str(self.folder)))


@dataclass
class Trust:
    """Decides which plugin files may run; asks at most once a folder.

    By default those may that the user has trusted before, and those that graphnav itself wrote.
    """

    runs_all: bool = False
    """Whether the user named what is to run: everything may."""
    ask: Callable[[Request], bool] | None = None
    """Asks the user about files that are not trusted; None: they are left out."""
    hint: str = "pass trust=True to run it"
    """The advice on a file that was left out."""
    folder_hint: str = ""
    """Added to it where trust in the folder would help; ``{folder}`` is the folder that names the file."""
    _answers: dict[Request, bool] = field(default_factory=dict)

    def allows(self, request: Request) -> bool:
        """Return whether the files may run; an answer of the user holds for this process, and yes is remembered."""
        if self.runs_all or is_trusted(request):
            return True
        if request not in self._answers:
            self._answers[request] = self.ask is not None and self.ask(request)
            if self._answers[request] and (why := request.remember()):
                print_notice(f"this answer is not remembered: {why}")
        return self._answers[request]

    def refused(self) -> tuple[Path, ...]:
        """Return the files that were not allowed so far, each once."""
        return tuple(dict.fromkeys(file for request, may in self._answers.items() if not may for file in request.files))

    def advice(self, request: Request) -> str:
        """Return what to do about files that were not allowed; folders that graphnav writes are not trusted by path."""
        if request.digest:
            return self.hint
        return self.hint + self.folder_hint.format(folder=shlex.quote(shown_path(request.folder)))


def read_plugin(path: Path) -> bytes:
    """Return the source of a plugin file.

    Raises
    ------
    OSError
        It cannot be read, or is not a regular file of at most `MAX_PLUGIN_BYTES`.
    """
    return read_regular(path, MAX_PLUGIN_BYTES)


def remember_written(files: Mapping[str, bytes]) -> None:
    """Remember the plugins that are written into a run folder, by their paths in it: they are this user's.

    Where that is not possible, what reads the folder will ask.
    """
    _change(lambda known: known.with_digest(_digest(files)))


def is_trusted(request: Request) -> bool:
    """Return whether the user trusts the folder, or graphnav wrote what it holds."""
    known = _read()
    return request.digest in known.digests if request.digest else str(request.folder) in known.folders


def forget(folder: Path) -> str:
    """Trust a folder no longer; return why that is not possible, empty if it is."""
    return _change(lambda known: _Known(tuple(f for f in known.folders if f != str(folder)), known.digests))


def trusted_folders() -> tuple[str, ...]:
    """Return the folders that the user trusts, sorted."""
    return tuple(sorted(_read().folders))


def state_file() -> Path | None:
    """Return the file that trust is kept in; None without a home folder."""
    folder = user_folder("XDG_STATE_HOME")
    return None if folder is None else folder / _FILE


@dataclass(frozen=True)
class _Known:
    """The content of the state file."""

    folders: tuple[str, ...] = ()
    digests: tuple[str, ...] = ()

    def with_folder(self, folder: str) -> _Known:
        return self if folder in self.folders else _Known((*self.folders, folder), self.digests)

    def with_digest(self, digest: str) -> _Known:
        return self if digest in self.digests else _Known(self.folders, (*self.digests, digest)[-_MAX_DIGESTS:])


def _read() -> _Known:
    """Return what is remembered; nothing where the file is damaged, or others may write it."""
    path = state_file()
    try:
        if path is None or not (is_own(path) and is_own(path.parent)):
            return _Known()
        data = json.loads(read_regular(path, MAX_JSON_BYTES))  # not `read_json`: names of folders need not be UTF-8
    except (OSError, ValueError, RecursionError):
        return _Known()
    words = data if isinstance(data, dict) else {}
    return _Known(_strings(words.get("folders")), _strings(words.get("written")))


def _strings(found: object) -> tuple[str, ...]:
    return tuple(item for item in found if isinstance(item, str)) if isinstance(found, list) else ()


def _change(change: Callable[[_Known], _Known]) -> str:
    """Apply a change to what is remembered; return why that is not possible, empty if it is."""
    path = state_file()
    if path is None:
        return no_user_folder("XDG_STATE_HOME")
    if change(before := _read()) == before:
        return ""
    try:
        path.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
        if not is_own(path.parent):
            return f"others may write into {path.parent}"
        with _locked(path.parent):
            after = change(_read())
            write_atomically(path, json.dumps({"folders": after.folders, "written": after.digests}, indent=1) + "\n")
            path.chmod(0o600)
    except OSError as error:
        return f"cannot write {path}: {error.strerror}"
    except GraphnavError as error:
        return str(error)
    return ""


@contextmanager
def _locked(folder: Path) -> Iterator[None]:
    """Keep other processes of this user from changing the state meanwhile; the kernel ends the lock with the file."""
    lock = open_file(folder / f".{_FILE}.lock", os.O_WRONLY | os.O_CREAT, 0o600)
    try:
        lock_file(lock, waits=True)
        yield
    finally:
        os.close(lock)


def _files_below(folder: Path) -> dict[Path, bytes]:
    """Return all that stands below a folder; what cannot be read, or is too much, is told by its name."""
    found: dict[Path, bytes] = {}
    for parent, folders, names in os.walk(folder):
        linked = (name for name in folders if os.path.islink(os.path.join(parent, name)))
        for name in (*names, *linked):
            found[Path(parent, name)] = _content(Path(parent, name))
            if len(found) > _MAX_BESIDE:
                return found | {folder: b"more"}
    return found


def _content(path: Path) -> bytes:
    try:
        return read_plugin(path)
    except OSError as error:
        return f"unreadable: {error.strerror}".encode()


def _digest(files: Mapping[str, bytes]) -> str:
    """Return one hash of files by name; names are hashed too, so that no two sets have the same."""
    found = hashlib.sha256()
    for name in sorted(files):
        found.update(hashlib.sha256(os.fsencode(name)).digest())
        found.update(hashlib.sha256(files[name]).digest())
    return found.hexdigest()
