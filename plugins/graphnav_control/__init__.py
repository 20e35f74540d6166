"""Stages of the family ``control``: from a direction to the robot's speeds."""

from graphnav import Stage, hookimpl


@hookimpl
def graphnav_stages() -> list[type[Stage]]:
    """Return the stages of the family."""
    from graphnav_control.guard import Guard
    from graphnav_control.nonholonomic import Nonholonomic
    from graphnav_control.stop_and_look import StopAndLook
    from graphnav_control.wander import Wander

    return [Guard, Nonholonomic, StopAndLook, Wander]
