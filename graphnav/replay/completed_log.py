"""Complete a log by what it leaves out: a replay makes it again, and a cache keeps it."""

from __future__ import annotations

import atexit
import errno
import hashlib
import os
import shutil
import tempfile
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

from graphnav import About, GraphnavError, Recording, UserError, __version__
from graphnav.core.catalog import Catalog
from graphnav.core.errors import LogError, message_line, shown_name
from graphnav.core.machine import is_own, user_folder
from graphnav.core.record import parts_of
from graphnav.core.run_folder import RunFolder
from graphnav.core.trust import Request, read_plugin
from graphnav.replay.comparison.result import ReplayResult
from graphnav.replay.log.log_graph import graph_to_replay, is_live
from graphnav.replay.replay import ReplayOptions, replay

MAX_CACHE_BYTES = 2 << 30
"""Of all completed logs together; those that were not used for the longest time are removed, the newest never."""
_MIN_FREE_BYTES = 128 << 20
"""Free space of the disk that a log which is being made leaves to others."""
_UNFINISHED_S = 3600.0
"""A file that was not written for this long was left by a process that died."""
_SUFFIX = ".lcmlog"
_CHUNK_BYTES = 1 << 20


class Completion(NamedTuple):
    """The file with everything, None if it cannot be made; then ``why``. ``wall_s``: 0 if it had been made before."""

    content: Path | None
    why: str = ""
    wall_s: float = 0.0
    hint: str = "'graphnav replay' tells more"


def cache_folder() -> Path | None:
    """Return the folder of completed logs, below ``XDG_CACHE_HOME`` or ``~/.cache``; None without a home folder."""
    folder = user_folder("XDG_CACHE_HOME")
    return None if folder is None else folder / "logs"


def complete(
    recording: Recording, catalog: Catalog, plugins: Sequence[Path], on_tick: Callable[[int], None]
) -> Completion:
    """Return the file with every message of a log that leaves some out; a replay makes it if the cache has none.

    See `graphnav.core.api.logs.open_completed.open_completed`.
    """
    if is_live(recording.about):
        return Completion(None, "live stages do not publish the same again")
    try:
        kept = _kept_path(recording.path, plugins)
        if kept is not None and kept.is_file():
            with suppress(OSError):
                os.utime(kept)
            return Completion(kept)
        made = graph_to_replay(recording, catalog, plugins=plugins)  # loads the plugins of the run, if trusted
        pending, begin_s = _pending_path(kept), time.monotonic()
        try:
            result = replay(
                recording,
                made,
                ReplayOptions(),
                out=pending,
                about=_about(recording),
                on_tick=_leaving_room(pending.parent, on_tick),
            )
            why = _why_not(recording, result)
            wall_s = time.monotonic() - begin_s
            return Completion(None, why) if why else Completion(_keep(pending, kept), wall_s=wall_s)
        except (LogError, OSError) as error:
            cause = error if isinstance(error, OSError) else error.__cause__
            if not isinstance(cause, OSError):
                raise
            hint = "free space there, or name another cache folder by XDG_CACHE_HOME"
            return Completion(None, f"cannot write into {pending.parent}: {cause.strerror}", hint=hint)
        finally:
            pending.unlink(missing_ok=True)
    except UserError as error:
        if untrusted := [problem for problem in error.problems if problem.kind == "untrusted"]:
            names = ", ".join(sorted(shown_name(file.name) for file in catalog.trust.refused()))
            why = f"its plugins are Python code that is not trusted ({names})"
            return Completion(None, why, hint=str(untrusted[0].hint))
        return Completion(None, error.problems[0].what)
    except GraphnavError as error:
        return Completion(None, message_line(error))
    except OSError as error:
        return Completion(None, f"{error.filename or recording.path}: {error.strerror}")


def _leaving_room(folder: Path, on_tick: Callable[[int], None]) -> Callable[[int], None]:
    """Return what is called at each tick: it raises OSError once the disk of a folder is nearly full."""

    def checked(utime: int) -> None:
        if shutil.disk_usage(folder).free < _MIN_FREE_BYTES:
            raise OSError(errno.ENOSPC, f"less than {_MIN_FREE_BYTES >> 20} MiB would stay free")
        on_tick(utime)

    return checked


def _about(recording: Recording) -> About | None:
    """Return the description that the log would have had if it had kept everything."""
    about = recording.about
    if about is None:
        return None
    lines = about.graph_yaml.splitlines(keepends=True)
    yaml = "".join(line.replace("replayable", "all") if line.startswith("  record: ") else line for line in lines)
    return replace(about, graph_yaml=yaml)


def _why_not(recording: Recording, result: ReplayResult) -> str:
    """Return why the replay is not the recorded run; empty if it is, to the end of the log."""
    differing = [name for name, channel in result.channels.items() if not channel.is_equal]
    if differing:
        return f"a replay does not come out equal here, on {', '.join(differing[:3])}"
    after = {head.logged_us for head in recording.heads() if head.logged_us > round(result.until_s * 1e6)}
    if len(after) > 1:  # a run that failed, or was killed, may have begun one tick more
        return result.failure or f"a replay ends at {result.until_s:.2f} s"
    return ""


def _kept_path(log: Path, plugins: Sequence[Path]) -> Path | None:
    """Return the place of the completed log in the cache; None without one that only this user may write.

    What a replay depends on names it: the version of graphnav, the content of the log, of the graph and all plugin
    files beside it, of ``plugins``, and the folder, from which relative paths lead. So the copy of a log beside other
    files does not become what is shown of the original.
    """
    folder = cache_folder()
    if folder is None:
        return None
    try:
        folder.mkdir(parents=True, exist_ok=True, mode=0o700)
    except OSError:
        return None
    if not os.access(folder, os.W_OK | os.X_OK) or not is_own(folder):
        return None
    try:
        beside = {
            path.resolve(): read_plugin(path) for path in (*plugins, log.parent / RunFolder.GRAPH) if path.is_file()
        }
    except OSError:
        return None
    home = log.parent.resolve()
    digest = hashlib.sha256(os.fsencode(f"{__version__}\n{home}\n{Request.digest_of_run(home, beside)}\n"))
    for part in parts_of(log):
        with part.open("rb") as file:
            while block := file.read(_CHUNK_BYTES):
                digest.update(block)
    return folder / f"{digest.hexdigest()}{_SUFFIX}"


def _pending_path(kept: Path | None) -> Path:
    """Return a path for the log that is being made; without a cache in a folder that ends with this process."""
    if kept is not None:
        return kept.with_name(f".{kept.stem}.{os.getpid()}.{time.monotonic_ns()}")
    scratch = tempfile.mkdtemp(prefix="graphnav_log_")
    atexit.register(shutil.rmtree, scratch, ignore_errors=True)
    return Path(scratch) / "made"


def _keep(pending: Path, kept: Path | None) -> Path:
    """Give a complete log its name, and remove old ones beyond the size of the cache."""
    if kept is None:
        return pending.rename(pending.with_name(f"full{_SUFFIX}"))
    pending.replace(kept)
    logs = []
    for path in kept.parent.iterdir():
        with suppress(OSError):  # another process removed it
            found = path.stat()
            if path.suffix == _SUFFIX:
                logs.append((found.st_mtime_ns, found.st_size, path))
            elif time.time() - found.st_mtime > _UNFINISHED_S:
                path.unlink()
    n_bytes = sum(size for _, size, _ in logs)
    for _, size, path in sorted(logs):
        if n_bytes <= MAX_CACHE_BYTES or path == kept:
            break
        path.unlink(missing_ok=True)
        n_bytes -= size
    return kept
