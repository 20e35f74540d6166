"""A share of a processor core for some processes: a control group with a quota, of Linux."""

from __future__ import annotations

import itertools
import os
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from types import TracebackType
from typing import Self

from graphnav.core.errors import UserError
from graphnav.core.machine.system import require_linux

_PERIOD_US = 10_000
"""Short, so that a process is held up often and briefly, as by a slower processor, never for a tenth of a second."""
_MIN_QUOTA_US = 1_000
"""The kernel takes no smaller quota: below 10 % the period is longer."""
_MAX_SHARES, _MAX_WEIGHT = 262_144, 10_000
_PROCESSES = "cgroup.procs"
_NUMBERS = itertools.count()
_MOUNTS, _GROUPS = Path("/proc/self/mounts"), Path("/proc/self/cgroup")


class CpuQuota:
    """While entered, a control group whose processes together get ``percent`` of one core at most.

    `join` moves a process into it; those that it starts from then on are in it too. At the end all that are left in
    the group go back to where this process was. Within the machine the group goes before its neighbours, so that it
    also gets its share where other programs run.

    Raises UserError when entered: this is not Linux, or no control group can be written.
    """

    def __init__(self, percent: float) -> None:
        self.percent = percent
        self._group: Path | None = None
        self._before = ""

    def __enter__(self) -> Self:
        require_linux("a share of a processor is measured")
        found: list[str] = []
        for parent, is_v2 in _parents():
            try:
                self._group = self._made(parent, is_v2=is_v2)
            except OSError as error:
                found.append(f"{error.filename or parent}: {error.strerror}")
                continue
            self._before = str(_own_group(parent, is_v2=is_v2) / _PROCESSES)
            return self
        reason = found[0] if found else "this system has none for processors"
        raise UserError.of(
            f"cannot limit the processor to {self.percent:g} % of a core: no control group can be made: {reason}",
            "run it as root, or let systemd limit it: systemd-run --user --scope -p CPUQuota="
            f"{self.percent:g}% COMMAND",
        )

    def join(self, process: int | None = None) -> None:
        """Move a process of this number, by default this one, into the group; raises OSError if that is refused."""
        assert self._group is not None
        (self._group / _PROCESSES).write_text(str(process or os.getpid()))

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        group = self._group
        assert group is not None
        for process in (group / _PROCESSES).read_text().split():
            with suppress(OSError):  # it has ended
                Path(self._before).write_text(process)
        with suppress(OSError):  # one that is ending is still in it
            group.rmdir()

    def _made(self, parent: Path, *, is_v2: bool) -> Path:
        """Return a new group below a parent; raises OSError where it cannot be made or limited."""
        quota_us = max(_MIN_QUOTA_US, round(_PERIOD_US * self.percent / 100))
        period_us = round(quota_us * 100 / self.percent)
        if is_v2 and "cpu" not in (parent / "cgroup.subtree_control").read_text().split():
            (parent / "cgroup.subtree_control").write_text("+cpu")
        group = parent / f"graphnav-{os.getpid()}-{next(_NUMBERS)}"
        group.mkdir()
        try:
            if is_v2:
                (group / "cpu.max").write_text(f"{quota_us} {period_us}")
                (group / "cpu.weight").write_text(str(_MAX_WEIGHT))
            else:
                (group / "cpu.cfs_period_us").write_text(str(period_us))
                (group / "cpu.cfs_quota_us").write_text(str(quota_us))
                (group / "cpu.shares").write_text(str(_MAX_SHARES))
            if not os.access(group / _PROCESSES, os.W_OK):
                raise PermissionError(13, "Permission denied", str(group / _PROCESSES))
        except OSError:
            group.rmdir()
            raise
        return group


def _parents() -> Iterator[tuple[Path, bool]]:
    """Yield groups below which one may be made, the nearest first, and whether they are of cgroup v2."""
    with suppress(OSError):
        for line in _MOUNTS.read_text().splitlines():
            _, mount, kind, options, *_ = line.split(" ")
            if kind == "cgroup" and "cpu" in options.split(","):
                yield _own_group(Path(mount), is_v2=False), False
            elif kind == "cgroup2":
                group = _own_group(Path(mount), is_v2=True)
                yield from ((one, True) for one in (group, *group.parents) if one.is_relative_to(mount))


def _own_group(mount: Path, *, is_v2: bool) -> Path:
    """Return the group of this process, as seen in a mount or below it."""
    root = next(one for one in (mount, *mount.parents) if one.parent == one or os.path.ismount(one))
    for line in _GROUPS.read_text().splitlines():
        _, controllers, path = line.split(":", 2)
        if (not controllers) if is_v2 else ("cpu" in controllers.split(",")):
            group = root / path.lstrip("/")
            return group if group.is_dir() else root  # a container sees its own group as the root
    return root
