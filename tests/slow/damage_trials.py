"""Run each command on a damaged log in this process: a process for each byte would take hours."""

from __future__ import annotations

import contextlib
import io
import os
import shutil
import tempfile
import warnings
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from multiprocessing import get_context
from pathlib import Path
from typing import NamedTuple

from graphnav.core.cli import main
from graphnav.core.errors import GraphnavError
from graphnav.core.record import Recording
from graphnav.watch.feed import Feed
from graphnav.watch.view import PageFeed

from .small_logs import STAGES

_CHUNK = 25


class Damage(NamedTuple):
    """Damage of a log: truncated to a size, or a bit flipped; ``bit``: counted from the first byte."""

    size: int
    bit: int | None = None

    def applied(self, data: bytes) -> bytes:
        """Return the damaged log."""
        if self.bit is None:
            return data[: self.size]
        spoiled = bytearray(data)
        spoiled[self.bit // 8] ^= 1 << self.bit % 8
        return bytes(spoiled)


class Trial(NamedTuple):
    """The result of a command on a damaged log, and its output."""

    command: str
    came_out: str
    """"used" or "refused" after reporting the loss; "complete": no loss can be detected; "silent": the loss was not
    reported; "crash"."""
    cause: str = ""


def _words(log: Path, scratch: Path, url: str) -> dict[str, list[str]]:
    """Return the command lines, by name."""
    plugin = ["--plugin", str(STAGES)]
    exports = {
        f"export {kind}": ["export", str(log), "--to", kind, "--force", "-o", str(scratch / f"out.{kind}")]
        for kind in ("csv", "mcap", "mp4")
    }
    return {
        "info": ["info", str(log)],
        "play": ["play", str(log), "--speed", "1e9", "--url", url],
        "replay": ["replay", str(log), *plugin],
        "replay -o": ["replay", str(log), *plugin, "-o", str(scratch / "again.lcmlog")],
        "figure": ["figure", str(log), "-o", str(scratch / "pictures")],
        **exports,
    }


COMMANDS = (*_words(Path(), Path(), ""), "view")


def count_trials(data: bytes, damages: Iterable[Damage], jobs: int) -> tuple[dict[str, Counter[str]], list[str]]:
    """Run every command on every damaged log; return how they came out by command, and what is wrong."""
    counts: dict[str, Counter[str]] = {name: Counter() for name in COMMANDS}
    wrong = []
    with ProcessPoolExecutor(jobs, mp_context=get_context("spawn")) as pool:
        given = list(damages)
        chunks = [given[first : first + _CHUNK] for first in range(0, len(given), _CHUNK)]
        done = [pool.submit(_try_all, data, chunk) for chunk in chunks]
        for future in done:
            for damage, trial in future.result():
                counts[trial.command][trial.came_out] += 1
                if trial.came_out in ("crash", "silent"):
                    wrong.append(f"{trial.command}, {damage}: {trial.came_out} {trial.cause}")
    return counts, wrong


def _try_all(data: bytes, damages: Iterable[Damage]) -> list[tuple[Damage, Trial]]:
    number = os.getpid() % 250 + 1
    url = f"udpm://239.255.92.{number}:{9200 + number}?ttl=0"
    found = []
    with tempfile.TemporaryDirectory() as folder:
        for damage in damages:
            log = Path(folder) / "damaged.lcmlog"
            log.write_bytes(damage.applied(data))
            scratch = Path(folder) / "scratch"
            scratch.mkdir()
            found += [(damage, trial) for trial in try_commands(log, scratch, url)]
            shutil.rmtree(scratch)
    return found


def try_commands(log: Path, scratch: Path, url: str) -> Iterator[Trial]:
    """Run every command on a log; files go to ``scratch``, messages to ``url``."""
    lost = lost_of(log)
    for name, words in _words(log, scratch, url).items():
        yield _trial(name, lost, partial(main, words))
        if name == "replay -o" and (scratch / "again.lcmlog").exists():
            again = _trial("replay -o", lost, partial(_read_again, scratch / "again.lcmlog"), is_told=True)
            if again.came_out == "crash":
                yield again
    yield _trial("view", lost, partial(_view, log))


def lost_of(log: Path) -> list[str] | None:
    """Return what the reader of logs says is lost, None where the file is not a log at all."""
    try:
        with Recording(log) as recording:
            return [*map(str, recording.damaged), *([str(recording.truncated)] if recording.truncated else [])]
    except GraphnavError:
        return None


def _trial(name: str, lost: list[str] | None, run: Callable[[], int], *, is_told: bool = False) -> Trial:
    said = io.StringIO()
    try:
        with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said), warnings.catch_warnings():
            warnings.simplefilter("error")
            status = run()
    except (Exception, SystemExit) as error:  # noqa: BLE001 - the finding
        return Trial(name, "crash", f"{type(error).__name__}: {error}")
    text = said.getvalue()
    if status not in (0, 1, 2) or "Traceback" in text or not all(c.isprintable() or c in "\n\r" for c in text):
        return Trial(name, "crash", f"status {status}: {text}")
    if not lost and status != 2:
        return Trial(name, "complete")
    is_told = is_told or not lost or any(one in text for one in lost) or f"in {len(lost)} places" in text
    return Trial(name, ("refused" if status == 2 else "used") if text and is_told else "silent", text)


def _read_again(log: Path) -> int:
    """Check that the log of a replay is complete."""
    lost = lost_of(log)
    if lost != []:
        raise ValueError(f"the log of the replay is damaged: {lost}")
    return 0


def _view(log: Path) -> int:
    """Play a log as the page does: to its end, back, and step by step."""
    try:
        source = PageFeed(Feed(str(log)))
    except GraphnavError as error:
        print(error)
        return 2
    source.start()
    try:
        with source.lock:
            assert source.log is not None
            source.log.seek(source.log.length_s)
            source.log.step(-1, None)
            source.log.step(1, None)
            source.log.seek(0.0)
    finally:
        source.close()
    print(source.damage)
    return 0
