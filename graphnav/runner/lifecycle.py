"""Begin and end of the stages of a run."""

from __future__ import annotations

from collections.abc import Mapping

from graphnav.errors import StageError, message_line, one_line
from graphnav.runner.seeds import seed_of
from graphnav.runner.unit import Unit


def reset_stages(units: Mapping[str, Unit], seed: int) -> None:
    """Make every stage's state anew from the run's ``seed``.

    Raises
    ------
    StageError
        A stage cannot be made ready.
    """
    for name, unit in units.items():
        try:
            unit.stage.reset(seed_of(seed, name))
        except (Exception, SystemExit) as error:
            what = message_line(error) or one_line(error)
            raise StageError(name, unit.node.use, 0.0, what) from error


def close_stages(units: Mapping[str, Unit], at_s: float) -> None:
    """Release what the stages hold; each is closed, also if another one fails to.

    Raises
    ------
    StageError
        The first failure, once every stage was closed.
    """
    failed = None
    for name, unit in units.items():
        try:
            unit.stage.close()
        except Exception as error:  # noqa: BLE001 - a plugin's code, and the others must still be closed
            failed = failed or StageError(name, unit.node.use, at_s, f"close: {error}")
    if failed:
        raise failed
