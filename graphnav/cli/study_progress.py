"""The progress bar of a study."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

_WHOLE_SESSION_S = 1e9


@contextmanager
def study_bar(console: Console, title: str, done: int, total: int) -> Iterator[Callable[[str], None]]:
    """Show how many runs are made, how they ended, and the time left by the mean of those made while entered.

    Call what is yielded with each run's outcome. Nothing is shown where no one looks.
    """
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        TextColumn("{task.completed} of {task.total} runs{task.fields[ended]}"),
        TimeRemainingColumn(elapsed_when_finished=True),
    )
    ended = Counter[str]()
    with Progress(
        *columns,
        console=console,
        transient=True,
        disable=not console.is_terminal,
        speed_estimate_period=_WHOLE_SESSION_S,
    ) as progress:
        task = progress.add_task(title, total=total, completed=done, ended="")

        def show(outcome: str) -> None:
            ended[outcome] += 1
            said = ", ".join(f"{name} {count}" for name, count in ended.most_common())
            progress.update(task, advance=1, ended=f": {said}")

        yield show
