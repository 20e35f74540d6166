"""Scores: stages that compare with the truth and report in the run's summary; the family ``score``."""

from graphnav import Stage, hookimpl


@hookimpl
def graphnav_stages() -> list[type[Stage]]:
    """Return the stages of the family."""
    from graphnav_score.agreement import Agreement
    from graphnav_score.barn import Barn
    from graphnav_score.components import Components
    from graphnav_score.flow import Flow
    from graphnav_score.labels import Labels
    from graphnav_score.laps import Laps
    from graphnav_score.navigation import Navigation
    from graphnav_score.plane import Plane
    from graphnav_score.sighting import Sighting
    from graphnav_score.steering import Steering

    return [Agreement, Barn, Components, Flow, Labels, Laps, Navigation, Plane, Sighting, Steering]
