"""The progress bar of a study."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from datetime import timedelta

from rich.progress import BarColumn, Progress, ProgressColumn, Task, TextColumn
from rich.text import Text

from graphnav.core.machine import Console


class _TimeLeft(ProgressColumn):
    """The remaining time, by what is known of the runs, else from the mean of those completed while it is shown."""

    def render(self, task: Task) -> Text:
        over_s = task.fields["over_s"]
        if over_s is None:
            return Text("? left")
        return Text(f"{timedelta(seconds=max(0, round(over_s - time.monotonic())))} left")


@contextmanager
def study_bar(
    console: Console, title: str, done: int, total: int, left_s: Callable[[], float | None] | None = None
) -> Iterator[Callable[[str], None]]:
    """Show the number of finished runs, their outcomes and the time left; call the yielded function per outcome.

    ``left_s`` tells the time left, in seconds; without it, or where it is not known, the mean of the runs does. Shows
    nothing without a terminal.
    """
    columns = (
        TextColumn("{task.description}", markup=False),
        BarColumn(),
        TextColumn("{task.completed} of {task.total} runs{task.fields[ended]}", markup=False),
        _TimeLeft(),
    )
    ended = Counter[str]()
    begin_s = time.monotonic()
    with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as progress:

        def over_s(made: int) -> float | None:
            now_s = time.monotonic()
            left = left_s() if left_s is not None and not progress.disable else None
            if left is None and made:
                left = (now_s - begin_s) / made * (total - done - made)
            return None if left is None else now_s + left

        task = progress.add_task(title, total=total, completed=done, ended="", over_s=over_s(0))

        def show(outcome: str) -> None:
            ended[outcome] += 1
            said = ", ".join(f"{name} {count}" for name, count in ended.most_common())
            progress.update(task, advance=1, ended=f": {said}", over_s=over_s(ended.total()))

        yield show
