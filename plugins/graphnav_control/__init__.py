"""From a direction to the robot's speeds; the family ``control``."""

from graphnav import Stage, hookimpl


@hookimpl
def graphnav_stages() -> list[type[Stage]]:
    """Return the stages of the family."""
    from graphnav_control.guard import Guard  # noqa: PLC0415  # only graphs that use the family pay for it
    from graphnav_control.nonholonomic import Nonholonomic  # noqa: PLC0415
    from graphnav_control.stop_and_look import StopAndLook  # noqa: PLC0415
    from graphnav_control.wander import Wander  # noqa: PLC0415

    return [Guard, Nonholonomic, StopAndLook, Wander]
