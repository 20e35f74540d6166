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
        try:
            unit.stage.reset(seed_of(seed, name))
        except (Exception, SystemExit) as error:
            what = message_line(error) or one_line(error)
            raise StageError(name, unit.node.use, 0.0, what) from error


def close_stages(units: Mapping[str, Unit], at_s: float) -> None:
    """Close every stage, even if another one fails to close.

    Raises
    ------
    StageError
        The first failure, after every stage was closed.
    """
    failed = None
    for name, unit in units.items():
        try:
            unit.stage.close()
        except Exception as error:  # noqa: BLE001 - plugin code; the others must still be closed
            failed = failed or StageError(name, unit.node.use, at_s, f"close: {error}")
    if failed:
        raise failed
