"""The progress bar of a run."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

from graphnav.core.machine.console import Console


@contextmanager
def progress_bar(console: Console, title: str, until_s: float | None) -> Iterator[Callable[[int], None]]:
    """Show simulated time; call the yielded function with each tick's stamp. Shows nothing without a terminal."""
    columns = (
        TextColumn("{task.description}", markup=False),
        BarColumn(),
        TextColumn("{task.fields[sim]}", markup=False),
        TimeElapsedColumn(),
    )
    with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as progress:
        task = progress.add_task(title, total=until_s, sim="")
        of = f" of {until_s:g} s" if until_s is not None else " s"

        def show(utime: int) -> None:
            progress.update(task, completed=utime / 1e6, sim=f"{utime / 1e6:.1f}{of}")

        yield show if console.is_terminal else lambda _: None
