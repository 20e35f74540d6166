"""Reset and close the stages of a run."""

from __future__ import annotations

from collections.abc import Mapping

from graphnav.errors import StageError, message_line, one_line
from graphnav.runner.seeds import seed_of
from graphnav.runner.unit import Unit


def reset_stages(units: Mapping[str, Unit], seed: int) -> None:
    """Reset the state of every stage from the run's ``seed``.

    Raises
    ------
    StageError
        A stage cannot be reset.
    """
    for name, unit in units.items():
        with unit.calling("reset", 0.0, _said):
            unit.stage.reset(seed_of(seed, name))


def close_stages(units: Mapping[str, Unit], at_s: float) -> None:
    """Close every stage, even if another one fails to close.

    Raises
    ------
    StageError
        The first failure, after every stage was closed.
    """
    failed = None
    for unit in units.values():
        try:
            with unit.calling("close", at_s, lambda error: f"close: {_said(error)}"):
                unit.stage.close()
        except StageError as error:  # the others must still be closed
            failed = failed or error
    if failed:
        raise failed


def _said(error: BaseException) -> str:
    """Return an exception in one line: the message, with the type where it would not tell enough."""
    return (message_line(error) if isinstance(error, Exception) else "") or one_line(error)
