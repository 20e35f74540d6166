"""Scores: stages that compare with the truth and report in the run's summary; the family ``score``."""

from graphnav import Stage, hookimpl


@hookimpl
def graphnav_stages() -> list[type[Stage]]:
    """Return the stages of the family."""
    from graphnav_score.agreement import Agreement  # noqa: PLC0415  # only graphs that use the family pay for it
    from graphnav_score.flow import Flow  # noqa: PLC0415
    from graphnav_score.navigation import Navigation  # noqa: PLC0415
    from graphnav_score.plane import Plane  # noqa: PLC0415
    from graphnav_score.steering import Steering  # noqa: PLC0415

    return [Agreement, Flow, Navigation, Plane, Steering]
